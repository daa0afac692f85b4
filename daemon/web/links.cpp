#include "daemon/web/links.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "daemon/shared/atomic_file.hpp"
#include "daemon/shared/key_file.hpp"

namespace ovws::web {
namespace {

constexpr std::size_t kTokenLength = 32;

bool is_token(const std::string& text) {
  return text.size() == kTokenLength &&
         text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

Result<Tokens> parse_links(const std::string& path, const std::string& text) {
  Tokens tokens;
  std::istringstream lines(text);
  std::string name;
  std::string link;
  while (lines >> name >> link) {
    const std::string token = link.substr(std::min(link.size(), link.find('#') + 1));
    if (!is_token(token) || (name != "look" && name != "control")) {
      return fail(Errc::invalid, "--links",
                  path + ": is not a file of ovws-web: remove it to make new links");
    }
    (name == "look" ? tokens.look : tokens.control) = token;
  }
  return tokens;
}

}  // namespace

std::string links_text(const std::string& host, const Tokens& tokens) {
  std::string text = "look http://" + host + "/#" + tokens.look + "\n";
  if (!tokens.control.empty()) text += "control http://" + host + "/#" + tokens.control + "\n";
  return text;
}

Result<Tokens> keep_links(const std::string& path, const std::string& host, bool control) {
  const Tokens fresh = make_tokens(true);
  Tokens tokens;
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored)) {
    const auto text =
        read_kept_file(path, S_IRWXG | S_IRWXO,
                       "group or others can read these links: remove the file to make new "
                       "ones");
    if (!text) return fail(text.error());
    const auto kept = parse_links(path, *text);
    if (!kept) return fail(kept.error());
    tokens = *kept;
  }
  if (tokens.look.empty()) tokens.look = fresh.look;
  if (tokens.control.empty() && control) tokens.control = fresh.control;
  if (!control) tokens.control.clear();
  if (auto written = replace_secret_file(path, links_text(host, tokens)); !written) {
    return fail(written.error());
  }
  return tokens;
}

}  // namespace ovws::web
