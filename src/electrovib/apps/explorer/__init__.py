"""The explorer: a page in the browser in which parameters are changed and their effect is seen."""
