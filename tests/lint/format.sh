#!/bin/sh
# Every source file is as .clang-format has it.
set -eu
cd "$1"
git ls-files -z '*.hpp' '*.cpp' '*.inc' | xargs -0 clang-format --dry-run --Werror
