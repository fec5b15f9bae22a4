"""Print the lowest versions that pyproject.toml allows with the extras EXTRA,EXTRA, as constraints of pip."""

import re
import sys
import tomllib
from pathlib import Path

text = (Path(__file__).parent.parent / "pyproject.toml").read_text(encoding="utf-8")
project = tomllib.loads(text)["project"]
extras = project["optional-dependencies"]
chosen = [each for extra in sys.argv[1].split(",") for each in extras[extra]]
for requirement in [*project["dependencies"], *chosen]:
    print(re.sub(r"(\[.*\])?>=([^,]+).*", r"==\2", requirement))
