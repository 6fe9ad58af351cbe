"""A process that is killed between two renames."""

AT_A_RENAME = """
import os, sys
at, moves, rename = int(sys.argv.pop(1)), [], os.replace
def replace(source, destination):
    moves.append(source)
    if len(moves) == at:
        os.kill(os.getpid(), 9)
    rename(source, destination)
os.replace = replace
"""  # the first argument says which rename
