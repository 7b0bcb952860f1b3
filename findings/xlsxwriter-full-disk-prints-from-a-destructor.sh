#!/usr/bin/env bash
# XlsxWriter: after an error of `close()`, text about an ignored exception is printed later.
#
# Expected: a workbook that cannot be written raises one exception from `close()`, which the
# program handles; nothing else is printed.
# Seen: on a full disk `close()` raises FileCreateError, and when that error is dropped, Python
# prints "Exception ignored in: <function ZipFile.__del__ ...>" with a traceback to the standard
# error: the archive tries to write its end once more when it is deleted.
# Versions: xlsxwriter 3.3.1, CPython 3.11.7, Linux on x86-64 (it needs /dev/full).
# Source: measurement; the archive is not closed where writing it fails, and stays alive in the
# frames of the error's traceback.
# Why it matters: a program that promises one line for an error prints a traceback beside it.
# Writing the workbook to memory and then to the file avoids it.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check xlsxwriter==3.3.1

"$folder/venv/bin/python" - 2>"$folder/errors" <<'PROGRAM'
import xlsxwriter

book = xlsxwriter.Workbook("/dev/full")
book.add_worksheet().write_row(0, 0, range(100))
try:
    book.close()
except xlsxwriter.exceptions.FileCreateError as error:
    print("the program handles:", error)
del book
PROGRAM
echo "printed to the standard error: $(wc -l <"$folder/errors") lines"
grep "Exception ignored in" "$folder/errors" || { echo "this is no longer what was found"; exit 1; }
