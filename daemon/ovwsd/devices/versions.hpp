/// The versions of ovws and of its numerical library, Eigen, by name.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace ovws {

std::vector<std::pair<std::string, std::string>> versions();

}  // namespace ovws
