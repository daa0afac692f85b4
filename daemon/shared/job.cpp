#include "daemon/shared/job.hpp"

#include <chrono>
#include <thread>

namespace ovws::cli {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kJobPollInterval{100};

}  // namespace

std::string message_of(const CallFailure& failure) {
  const auto found = failure.error.find("message");
  const bool is_text = found != failure.error.end() && found->is_string();
  return is_text ? found->get<std::string>() : "no reason given";
}

Answer call_patiently(const Common& common, const std::string& method, const json& params,
                      double patience_s) {
  const auto end = Clock::now() + std::chrono::duration<double>(patience_s);
  for (;;) {
    auto answer = call(common, method, params);
    const bool is_silent = !answer && !answer.error().answered;
    if (!is_silent || Clock::now() > end) return answer;
    std::this_thread::sleep_for(kJobPollInterval);
  }
}

Answer end_of_job(const Common& common, const json& job, const JobWait& wait) {
  for (bool is_cancelled = false;;) {
    if (!is_cancelled && wait.is_cancelled && wait.is_cancelled()) {
      is_cancelled = true;
      auto done = call_patiently(common, "job.cancel", {{"job", job}}, wait.patience_s);
      if (!done) return done;
    }
    auto report = call_patiently(common, "job.get", {{"job", job}}, wait.patience_s);
    if (!report) return report;
    if (wait.progress) wait.progress(*report);
    const std::string state = report->at("state").get<std::string>();
    if (state == "done") return report->at("result");
    if (state != "running") {
      const json& error = report->at("error");
      return tl::make_unexpected(error.is_object() ? CallFailure{true, error}
                                                   : failure("the job was " + state));
    }
    std::this_thread::sleep_for(kJobPollInterval);
  }
}

Answer call_and_wait(const Common& common, const std::string& method, const json& params,
                     const JobWait& wait) {
  auto answer = call(common, method, params);
  const bool is_job =
      answer && answer->is_object() && answer->contains("job") && answer->size() == 1;
  return is_job ? end_of_job(common, answer->at("job"), wait) : answer;
}

}  // namespace ovws::cli
