/// ovws watch on a terminal: a page that is drawn anew as the bench goes on.
#pragma once

#include "daemon/ovws/cli/commands.hpp"

namespace ovws::cli {

/// Whether somebody sits there: input and output are a terminal on which a page can be drawn.
bool can_show_screen();

/// Until q, Ctrl-C or the end of the terminal. Returns the exit code.
int show_screen(const Common& common);

}  // namespace ovws::cli
