/// The links that open the page, each with its token in the fragment, which no browser sends to
/// anybody.
#pragma once

#include <string>

#include "core/base/result.hpp"
#include "daemon/web/access.hpp"

namespace ovws::web {

/// "look http://HOST/#TOKEN" and, if there is one for it, "control http://HOST/#TOKEN", a line
/// each.
std::string links_text(const std::string& host, const Tokens& tokens);

/// The tokens of a file of such lines, made if it is not there, so that links stay good over a
/// restart; the file is written anew with this host, mode 0600. Errors: Errc::invalid for a file
/// that others can read or that holds something else, Errc::unavailable if it cannot be written.
Result<Tokens> keep_links(const std::string& path, const std::string& host, bool control);

}  // namespace ovws::web
