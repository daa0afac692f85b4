/// ovws call: any method of a daemon, and the jobs that methods start.
#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/study/parallel.hpp"
#include "daemon/ovws/text/params.hpp"
#include "daemon/shared/client.hpp"
#include "daemon/shared/schemas/schemas.hpp"
#include "proto/json_text.hpp"
#include "proto/reader.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

constexpr std::chrono::milliseconds kPollInterval{200};

/// Progress line of a job on the terminal. The destructor removes the line.
class ProgressLine {
 public:
  ProgressLine() = default;
  ~ProgressLine() { study::print_progress(""); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Shows the job's progress. `job`: a result of job.get.
  void show(const json& job) {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin_;
    study::print_progress(fmt::format("{}: {:.0f} %, {:.0f} s", job.value("kind", "job"),
                                      100.0 * job.at("progress").get<double>(), passed.count()));
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// Waits for the job in `started` and returns its result or its error.
tl::expected<json, CallFailure> end_of_job(const Common& common, const json& started) {
  ProgressLine progress;
  while (true) {
    auto report = call(common, "job.get", {{"job", started.at("job")}});
    if (!report) return report;
    progress.show(*report);
    const std::string state = report->value("state", "");
    if (state == "done") return report->at("result");
    if (state != "running") {
      json error = report->at("error");
      if (!error.is_object()) error = {{"message", "the job was " + state}};
      return tl::make_unexpected(CallFailure{true, std::move(error)});
    }
    std::this_thread::sleep_for(kPollInterval);
  }
}

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

/// Prints a mistake of the command line on stderr (as JSON on stdout with --json).
int report_mistake(const Common& common, const Error& error) {
  report(common, error);
  return kUsage;
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
  auto answer = call(common, options.method, *params);
  if (answer && options.wait && answer->is_object() && answer->contains("job")) {
    answer = end_of_job(common, *answer);
  }
  if (!answer) return report_failure(common, answer.error());
  print("{}\n", common.json ? json_text(*answer) : readable(*answer));
  return kOk;
}

}  // namespace ovws::cli
