/// ovws call: any method of a daemon.
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/request.hpp"
#include "daemon/ovws/text/answer.hpp"
#include "daemon/ovws/text/params.hpp"
#include "daemon/shared/schemas/schemas.hpp"
#include "proto/json_text.hpp"
#include "proto/reader.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

/// Formats JSON with indents; arrays of primitive values stay on one line.
std::string readable(const json& value, const std::string& margin = "") {
  const auto is_plain = [](const json& one) { return one.is_primitive(); };
  const bool is_line = value.is_primitive() || value.empty() ||
                       (value.is_array() && std::all_of(value.begin(), value.end(), is_plain));
  if (is_line) return json_text(value);
  std::string text = value.is_array() ? "[" : "{";
  const std::string inner = margin + "  ";
  for (const auto& [key, one] : value.items()) {
    text += (text.size() == 1 ? "\n" : ",\n") + inner;
    if (value.is_object()) text += json_text(json(key)) + ": ";
    text += readable(one, inner);
  }
  return text + "\n" + margin + (value.is_array() ? "]" : "}");
}

/// The mistake of a name that is almost that of a method. None: it may be a method of another
/// program, e.g. of the twin, or of another version.
std::optional<Error> misspelt(const std::string& method) {
  std::vector<std::string> known;
  for (const Schema& one : schemas()) {
    if (one.json.contains("params")) known.push_back(one.name);
  }
  const auto near = nearest_name(method, known);
  if (!near) return std::nullopt;
  return Error{Errc::invalid, method, "unknown method; did you mean " + *near + "?"};
}

}  // namespace

int call_method(const Common& common, const CallOptions& options) {
  const json& of_method = schema(options.method);
  const bool is_known = of_method.contains("params");
  if (const auto mistake = misspelt(options.method); !is_known && mistake) {
    return report_mistake(common, *mistake);
  }
  const auto params = params_of(is_known ? of_method.at("params") : any_params(), options.params);
  if (!params) return report_mistake(common, params.error());
  const auto answer = options.wait ? call_and_wait(common, options.method, *params)
                                   : call(common, options.method, *params);
  if (!answer) return report_failure(common, answer.error());
  const bool is_for_people = !common.json && isatty(STDOUT_FILENO) != 0;
  return print_answer(common, *answer,
                      is_for_people ? answer_text(options.method, *answer) : readable(*answer));
}

}  // namespace ovws::cli
