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

Error unknown_method(const std::string& method) {
  std::vector<std::string> known;
  for (const Schema& one : schemas()) {
    if (one.json.contains("params")) known.push_back(one.name);
  }
  const auto near = nearest_name(method, known);
  return {Errc::invalid, method,
          near ? "unknown method; did you mean " + *near + "?"
               : "unknown method; ovws describe lists all"};
}

}  // namespace

int call_method(const Common& common, const CallOptions& options) {
  const json& of_method = schema(options.method);
  if (!of_method.contains("params")) return report_mistake(common, unknown_method(options.method));
  const auto params = params_of(of_method.at("params"), options.params);
  if (!params) return report_mistake(common, params.error());
  const auto answer = options.wait ? call_and_wait(common, options.method, *params)
                                   : call(common, options.method, *params);
  if (!answer) return report_failure(common, answer.error());
  const bool is_for_people = !common.json && isatty(STDOUT_FILENO) != 0;
  return print_answer(common, *answer,
                      is_for_people ? answer_text(options.method, *answer) : readable(*answer));
}

}  // namespace ovws::cli
