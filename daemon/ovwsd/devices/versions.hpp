/// What is running: our version and those of the libraries that matter on a bench.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace ovws {

std::vector<std::pair<std::string, std::string>> versions();

}  // namespace ovws
