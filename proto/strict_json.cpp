#include "proto/strict_json.hpp"

#include <set>
#include <string>
#include <vector>

namespace ovws {
namespace {

using nlohmann::json;

/// Looks through the text without building anything; stops at the first fault.
class Inspector : public nlohmann::json_sax<json> {
 public:
  explicit Inspector(int max_depth) : max_depth_(max_depth) {}

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
    fault = {false, shown ? "the key \"" + name + "\" is given twice in one object"
                          : "a key is given twice in one object"};
    return false;
  }

  bool parse_error(std::size_t position, const std::string&,
                   const json::exception& error) override {
    fault = {true, "not JSON at byte " + std::to_string(position) + ": " + cause(error.what())};
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

  /// The library's words between its own prefix and the text last read, which may be long or not
  /// even UTF-8.
  static std::string cause(std::string text) {
    if (const auto end = text.find("; last read"); end != std::string::npos) text.resize(end);
    if (const auto begin = text.find(" - "); begin != std::string::npos)
      return text.substr(begin + 3);
    return text.find("number overflow") != std::string::npos ? "a number is too large"
                                                             : "syntax error";
  }

  int max_depth_;
  std::vector<std::set<std::string>> keys_;
};

}  // namespace

tl::expected<json, JsonFault> parse_strict_json(std::string_view text, int max_depth,
                                                JsonComments comments) {
  const bool ignore_comments = comments == JsonComments::allowed;
  if (text.empty()) return tl::make_unexpected(JsonFault{true, "empty: there is nothing to read"});
  if (const auto nul = text.find('\0'); nul != text.npos) {  // the library takes it for the end
    return tl::make_unexpected(
        JsonFault{true, "not JSON at byte " + std::to_string(nul + 1) + ": a NUL byte"});
  }
  Inspector inspector(max_depth);
  if (!json::sax_parse(text.begin(), text.end(), &inspector, json::input_format_t::json, true,
                       ignore_comments)) {
    return tl::make_unexpected(inspector.fault);
  }
  return json::parse(text.begin(), text.end(), nullptr, false, ignore_comments);
}

}  // namespace ovws
