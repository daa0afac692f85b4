#include "proto/strict_json.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

namespace ovws {
namespace {

using nlohmann::json;

/// Line of the character at `offset`, as "line 3".
std::string line_of(std::string_view text, std::size_t offset) {
  return "line " + std::to_string(std::ranges::count(text.substr(0, offset), '\n') + 1);
}

/// Place of the character at `offset`, as "line 3, column 5"; columns count characters, not bytes.
std::string place_of(std::string_view text, std::size_t offset) {
  const auto before = text.substr(0, offset);
  const auto line = before.substr(before.rfind('\n') + 1);  // npos + 1 is 0: the first line
  const auto column = std::ranges::count_if(line, [](char c) { return (c & 0xC0) != 0x80; });
  return line_of(text, offset) + ", column " + std::to_string(column + 1);
}

/// Iterator over the text that records how far the parser has read, because the SAX interface of
/// the library reports no position.
class TrackedText {
 public:
  using iterator_category = std::forward_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  TrackedText(const char* at, const char*& furthest) : at_(at), furthest_(&furthest) {}
  reference operator*() const { return *at_; }
  TrackedText& operator++() {
    *furthest_ = ++at_;
    return *this;
  }
  TrackedText operator++(int) {
    const TrackedText before = *this;
    ++*this;
    return before;
  }
  friend bool operator==(const TrackedText& a, const TrackedText& b) { return a.at_ == b.at_; }

 private:
  const char* at_;
  const char** furthest_;
};

/// SAX handler that checks the text without building a value and stops at the first fault.
class Inspector : public nlohmann::json_sax<json> {
 public:
  Inspector(std::string_view text, const char* const& read, int max_depth)
      : text_(text), read_(read), max_depth_(max_depth) {}

  JsonFault fault;

  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(number_integer_t) override { return true; }
  bool number_unsigned(number_unsigned_t) override { return true; }
  bool number_float(number_float_t, const string_t&) override { return true; }
  bool string(string_t&) override { return true; }
  bool binary(binary_t&) override { return true; }
  bool start_object(std::size_t) override { return enter(); }
  bool end_object() override { return leave(); }
  bool start_array(std::size_t) override { return enter(); }
  bool end_array() override { return leave(); }

  bool key(string_t& name) override {
    if (keys_.back().insert(name).second) return true;
    const bool shown = name.size() <= 40;
    fault = {false, (shown ? "the key \"" + name + "\"" : "a key") +
                        " is given twice in one object, the second time in " +
                        line_of(text_, std::size_t(read_ - text_.data()))};
    return false;
  }

  bool parse_error(std::size_t position, const std::string&,
                   const json::exception& error) override {
    fault = {true, "not JSON at " + place_of(text_, position - std::min<std::size_t>(position, 1)) +
                       ": " + cause(error.what())};
    return false;
  }

 private:
  bool enter() {
    keys_.emplace_back();
    if (int(keys_.size()) <= max_depth_) return true;
    fault = {false, "nested deeper than " + std::to_string(max_depth_) + " levels"};
    return false;
  }
  bool leave() {
    keys_.pop_back();
    return true;
  }

  /// The library's error text without its prefix and the text last read, which may be long or not
  /// UTF-8.
  static std::string cause(std::string text) {
    if (const auto end = text.find("; last read"); end != std::string::npos) text.resize(end);
    if (const auto begin = text.find(" - "); begin != std::string::npos)
      return text.substr(begin + 3);
    return text.find("number overflow") != std::string::npos ? "a number is too large"
                                                             : "syntax error";
  }

  std::string_view text_;
  const char* const& read_;
  int max_depth_;
  std::vector<std::set<std::string>> keys_;
};

}  // namespace

tl::expected<json, JsonFault> parse_strict_json(std::string_view text, int max_depth,
                                                JsonComments comments) {
  const bool ignore_comments = comments == JsonComments::allowed;
  if (text.empty()) return tl::make_unexpected(JsonFault{true, "empty: a JSON text is required"});
  if (const auto nul = text.find('\0'); nul != text.npos) {  // nlohmann's parser would stop here
    return tl::make_unexpected(
        JsonFault{true, "not JSON at " + place_of(text, nul) + ": a NUL byte"});
  }
  const char* read = text.data();
  Inspector inspector(text, read, max_depth);
  if (!json::sax_parse(TrackedText(text.data(), read), TrackedText(text.data() + text.size(), read),
                       &inspector, json::input_format_t::json, true, ignore_comments)) {
    return tl::make_unexpected(inspector.fault);
  }
  return json::parse(text.begin(), text.end(), nullptr, false, ignore_comments);
}

Result<std::string> read_small_file(const std::string& path) {
  constexpr std::size_t kMaxBytes = 1 << 20;
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  const bool missing = !file && errno == ENOENT;
  std::string text(kMaxBytes + 1, '\0');
  file.read(text.data(), std::streamsize(text.size()));
  if (file.good())
    return fail(Errc::invalid, "", "it is larger than 1 MiB, the limit for settings");
  if (file.bad() || !file.eof()) {
    return fail(missing ? Errc::unavailable : Errc::invalid, "",
                std::string("it cannot be read: ") + std::strerror(errno) +
                    "; check the path and the permissions");
  }
  text.resize(std::size_t(file.gcount()));
  return text;
}

}  // namespace ovws
