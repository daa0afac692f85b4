/// Links that open the page. The token is in the URL's fragment, which browsers never send.
#pragma once

#include <string>

#include "core/base/result.hpp"
#include "daemon/web/access.hpp"

namespace ovws::web {

/// One line each: "look http://HOST/#TOKEN" and, if that token exists, "control
/// http://HOST/#TOKEN".
std::string links_text(const std::string& host, const Tokens& tokens);

/// Loads the tokens from a file of such lines, or makes new ones, so that links stay valid over a
/// restart. Rewrites the file with this host, mode 0600. Errors: Errc::invalid for a file that
/// others can read or with other content, Errc::unavailable if it cannot be written.
Result<Tokens> keep_links(const std::string& path, const std::string& host, bool control);

}  // namespace ovws::web
