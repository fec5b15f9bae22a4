"""Applications: the command line, each command of which makes one call of a public function, and the page in the browser."""
