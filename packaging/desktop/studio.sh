#!/bin/sh
# What a double click starts: the program beside this one, in a window of its own.
exec "$(dirname "$0")/magician" studio --app
