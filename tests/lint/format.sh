#!/bin/sh
# Checks that every source file is formatted as .clang-format says.
set -eu
cd "$1"
git ls-files -z '*.hpp' '*.cpp' '*.inc' | xargs -0 clang-format --dry-run --Werror
