/// What bash needs to complete the command line of ovws.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace ovws::cli {

/// The whole script: its tables are made from the commands and options of `app`, and from the
/// schemas of the daemon's methods.
std::string bash_completion(const CLI::App& app);

}  // namespace ovws::cli
