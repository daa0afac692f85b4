#!/bin/sh
# Checks that every source file is formatted as .clang-format says. Other versions of clang-format decide differently: 77, skipped.
set -eu
cd "$1"
version=$(clang-format --version | sed 's/.*version \([0-9]*\).*/\1/')
[ "$version" = 14 ] || { echo "the sources are formatted with clang-format 14; this one is version $version"; exit 77; }
git ls-files -z '*.hpp' '*.cpp' '*.inc' | xargs -0 clang-format --dry-run --Werror
