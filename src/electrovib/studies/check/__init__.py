"""Check of a drive against limits, before it is written or played.

What leaves as a file to be played, or for a bench, has passed `cleared_for_output` or `cleared_as_played`, which refuse a
drive without a declared largest voltage and current, and one that exceeds a limit or cannot be compared with it. Nothing is
clipped. Limits declared in several places count by the strictest. A check has three outcomes, and a limit of uncertain standing
that is exceeded is no pass. Films are judged with the gap as declared and closed, in `solve/diagnostics/judge.py`, so that
every door which judges a limit has both.
"""

from electrovib.studies.check.amplifier import without_its_limits as without_its_limits
from electrovib.studies.check.function import check as check
from electrovib.studies.check.function import checked as checked
from electrovib.studies.check.function import cleared_as_played as cleared_as_played
from electrovib.studies.check.function import cleared_for_output as cleared_for_output
from electrovib.studies.check.function import declared_limits as declared_limits
from electrovib.studies.check.function import first_columns as first_columns
from electrovib.studies.check.function import refuse_demanded as refuse_demanded
from electrovib.studies.check.function import sampled as sampled
from electrovib.studies.check.function import several_limits as several_limits
from electrovib.studies.check.function import with_drive as with_drive
from electrovib.studies.check.result import NEEDED as NEEDED
from electrovib.studies.check.result import CheckResult as CheckResult
from electrovib.studies.check.result import CheckRow as CheckRow
from electrovib.studies.check.result import DeclaredLimit as DeclaredLimit
from electrovib.studies.check.result import LimitsFrom as LimitsFrom
from electrovib.studies.check.result import LimitsSource as LimitsSource
from electrovib.studies.check.result import not_shown as not_shown
from electrovib.studies.check.result import refuse_unlimited as refuse_unlimited
