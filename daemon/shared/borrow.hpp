/// What a program changes on a bench for a while, and restores.
#pragma once

#include <functional>
#include <initializer_list>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "daemon/shared/job.hpp"

namespace ovws::cli {

/// Methods with their params.
using Calls = std::vector<std::pair<std::string, nlohmann::json>>;

/// Parts of a bench in the order in which they are restored.
enum class Part {
  pattern,     ///< of the SLM
  camera,      ///< exposure and gain
  sensor,      ///< charges, tracker, operator, number of modes
  lut,         ///< a table that was not there before is cleared
  aberration,  ///< introduced by the user
  correction,  ///< of the loop
  loop         ///< closed as it was, or open
};

/// Parts as the params of the calls that restore them. Of the loop: {"closed": false}, or
/// {"closed": true, "paused", "params": those of loop.close}.
using Parts = std::map<Part, nlohmann::json>;

/// Reads parts of a bench. Errors: the daemon's; a DMD shows a sequence of patterns instead of an
/// aberration.
tl::expected<Parts, CallFailure> parts_of(const Common& common, std::initializer_list<Part> parts);

/// Restores the parts of a bench that have changed: at the latest in the destructor. Use it from
/// one thread.
class Borrow {
 public:
  struct Hooks {
    std::function<void()> waiting;  ///< a device refuses for the moment; called some times a second
    std::function<void(const std::string& message)> failed;  ///< the message of restore's error
  };

  /// `before`: what is restored.
  Borrow(Common common, Parts before, Hooks hooks = {})
      : common_(std::move(common)), before_(std::move(before)), hooks_(std::move(hooks)) {}
  ~Borrow() { (void)restore(); }
  Borrow(const Borrow&) = delete;
  Borrow& operator=(const Borrow&) = delete;

  const nlohmann::json& before(Part part) const { return before_.at(part); }
  /// What is in use now stays.
  void keep() { is_over_ = true; }
  /// Restores once. Tries again for some seconds, as a camera or display that is gone refuses
  /// meanwhile. The error says which calls would restore the rest.
  Answer restore();
  /// Restores after `done`. The error says why that failed, and what is not restored.
  template <class T>
  tl::expected<T, CallFailure> restore_after(tl::expected<T, CallFailure> done) {
    const Answer back = restore();
    if (back) return done;
    if (done) return tl::make_unexpected(back.error());
    CallFailure both = done.error();
    if (!both.error.is_object()) both.error = nlohmann::json::object();
    both.error["message"] = message_of(done.error()) + "; " + message_of(back.error());
    return tl::make_unexpected(std::move(both));
  }

 private:
  Answer try_restore() const;

  const Common common_;
  const Parts before_;
  const Hooks hooks_;
  bool is_over_ = false;
};

}  // namespace ovws::cli
