#include "daemon/ovws/cli/request.hpp"

#include <atomic>
#include <cmath>

#include "daemon/ovws/study/parallel.hpp"
#include "daemon/ovws/text/quantity.hpp"
#include "daemon/ovws/text/wrap.hpp"
#include "proto/json_text.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr double kLeastProgress = 0.05;  ///< with less, the time left is a guess

std::atomic<bool> interrupted{false};

/// Progress line of a job on the terminal. The destructor removes the line.
class ProgressLine {
 public:
  ProgressLine() = default;
  ~ProgressLine() { study::print_progress(""); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Shows the job's progress. `job`: a result of job.get.
  void show(const json& job) {
    const double done = job.at("progress").get<double>();
    std::string text = fmt::format("{}: {:.0f} %", job.at("kind").get<std::string>(), 100.0 * done);
    if (done >= kLeastProgress) {
      const double passed_s = std::chrono::duration<double>(Clock::now() - begin_).count();
      text += ", " + time_text(std::ceil(passed_s * (1.0 - done) / done)) + " left";
    }
    study::print_progress(text);
  }

 private:
  Clock::time_point begin_ = Clock::now();
};

}  // namespace

void catch_interrupts(std::initializer_list<int> signals) {
  for (const int signal : signals) {
    struct sigaction taken {};
    taken.sa_handler = [](int) { interrupted.store(true); };
    ::sigaction(signal, &taken, nullptr);  // no SA_RESTART: a write to a full pipe must end
  }
}

bool was_interrupted() {
  return interrupted;
}

Answer call_and_wait(const Common& common, const std::string& method, const json& params) {
  std::optional<ProgressLine> line;
  return call_and_wait(common, method, params,
                       {[&] {
                          if (!line) catch_interrupts();
                          if (!line) line.emplace();
                          return was_interrupted();
                        },
                        [&](const json& job) { line->show(job); }});
}

Answer newest_wavefront(const Common& common) {
  constexpr std::chrono::milliseconds kLongestWait{1000};
  auto stream = open_stream(common, "endpoint", {"wavefront"}, 1);
  if (!stream) return tl::make_unexpected(stream.error());
  const auto message = stream->receive(kLongestWait);
  return message ? json_of(message->json) : json();
}

int print_result(const Common& common, const json& result, const std::string& text,
                 std::optional<std::size_t> indent) {
  const bool is_wrapped = indent && !common.json;
  const std::string shown = common.json ? json_text(result) : text;
  print("{}\n", is_wrapped ? wrapped(shown, terminal_columns(), *indent) : shown);
  return kOk;
}

int report_mistake(const Common& common, const Error& error) {
  report(common, error);
  return kUsage;
}

}  // namespace ovws::cli
