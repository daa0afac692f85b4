/// ovws watch on a terminal: a full-screen view of the bench, updated live.
#pragma once

#include "daemon/ovws/cli/commands.hpp"

namespace ovws::cli {

/// Whether input and output are a terminal that can show the full screen (TERM is not "dumb").
bool can_show_screen();

/// Shows the screen until q, Ctrl-C or the end of the terminal. Returns the exit code.
int show_screen(const Common& common);

}  // namespace ovws::cli
