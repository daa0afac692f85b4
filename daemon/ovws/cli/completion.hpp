/// Generates the bash completion script of ovws.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace ovws::cli {

/// Returns the whole script. Its tables come from the commands and options of `app` and from the
/// schemas of the daemon's methods.
std::string bash_completion(const CLI::App& app);

}  // namespace ovws::cli
