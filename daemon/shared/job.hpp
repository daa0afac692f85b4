/// Jobs of the daemon as a client sees them: starts one, waits for its end, cancels it.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <utility>

#include "daemon/shared/client.hpp"

namespace ovws::cli {

using Answer = tl::expected<nlohmann::json, CallFailure>;

/// A failed call after which nothing is left to do but to report it.
struct CallFailed {
  CallFailure why;
};

/// Throws a failure that this program found.
[[noreturn]] inline void stop(std::string why) {
  throw CallFailed{failure(std::move(why))};
}
[[noreturn]] inline void stop(const Error& error) {
  throw CallFailed{failure(error)};
}

/// The value of an answer. Throws CallFailed if there is none.
template <class T>
T needed(tl::expected<T, CallFailure> answer) {
  if (!answer) throw CallFailed{std::move(answer.error())};
  if constexpr (!std::is_void_v<T>) return std::move(*answer);
}
template <class T>
T needed(Result<T> done) {
  if (!done) stop(done.error());
  if constexpr (!std::is_void_v<T>) return std::move(*done);
}

/// What `work` returns, or the failure that it throws as CallFailed.
template <class Work, class T = std::invoke_result_t<Work>>
tl::expected<T, CallFailure> attempt(Work work) try {
  if constexpr (!std::is_void_v<T>) {
    return work();
  } else {
    work();
    return {};
  }
} catch (CallFailed& failed) {
  return tl::make_unexpected(std::move(failed.why));
}

/// The failure's message; never empty. Throws nothing, whatever the daemon sent.
std::string message_of(const CallFailure& failure);

/// Calls a method, and again while the daemon does not answer: for `patience_s`, if there are
/// further calls to make in that time. A signal or a restart of the daemon may interrupt a call.
Answer call_patiently(const Common& common, const std::string& method, const nlohmann::json& params,
                      double patience_s = 1.0);

/// How to wait for a job. Both functions are called some times a second in the waiting thread.
struct JobWait {
  std::function<bool()> is_cancelled;  ///< once it is true, the job is cancelled
  std::function<void(const nlohmann::json& job)> progress;  ///< gets each result of job.get
  double patience_s = 1.0;                                  ///< as for call_patiently
};

/// Waits until the job has ended. Returns its result, or its error; of a job that was cancelled,
/// "the job was cancelled".
Answer end_of_job(const Common& common, const nlohmann::json& job, const JobWait& wait);

/// Calls a method. If it starts a job, waits for its end.
Answer call_and_wait(const Common& common, const std::string& method, const nlohmann::json& params,
                     const JobWait& wait);

}  // namespace ovws::cli
