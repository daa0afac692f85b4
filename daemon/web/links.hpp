/// Links that open the page. The token is in the URL's fragment, which browsers never send.
#pragma once

#include <string>

#include "core/base/result.hpp"
#include "daemon/web/access.hpp"

namespace ovws::web {

/// Links to the page, one per line: "look http://HOST/#TOKEN" and, if there is a control token,
/// "control http://HOST/#TOKEN".
std::string links_text(const std::string& host, const Tokens& tokens);

/// Loads the tokens from a file in the form of links_text, or makes new tokens. Links thus stay
/// valid when the server restarts. Rewrites the file for `host`, with mode 0600. Errors:
/// Errc::invalid for a file that others can read or with other content, Errc::unavailable if it
/// cannot be written.
Result<Tokens> keep_links(const std::string& path, const std::string& host, bool control);

}  // namespace ovws::web
