/// What `ovws check` changes on a bench, and restores.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>

#include "daemon/ovws/check/measured.hpp"
#include "daemon/shared/client.hpp"

namespace ovws::check {

using Answer = tl::expected<nlohmann::json, cli::CallFailure>;

/// A failure that this program found, in the form of an error of the daemon.
inline cli::CallFailure failure(std::string message) {
  return {true, {{"message", std::move(message)}}};
}

/// Changes aberration, loop and look-up table of a bench, and restores them at the end. The
/// destructor restores, too. Use it from one thread.
class Borrowed {
 public:
  /// `common` must outlive this object.
  explicit Borrowed(const cli::Common& common) : common_(common) {}
  ~Borrowed() { (void)restore(); }
  Borrowed(const Borrowed&) = delete;
  Borrowed& operator=(const Borrowed&) = delete;

  /// Reads what will be restored. The other functions require that it has succeeded.
  Answer remember();
  bool loop_was_closed() const { return loop_.at("closed").get<bool>(); }
  /// `loop.close`'s params of the loop as it was.
  nlohmann::json loop_params() const;

  /// Shows the aberration as it was plus `waves` of mode j; returns the result of aberration.set.
  Answer poke(int j, double waves);
  /// Shows the aberration as it was.
  Answer unpoke();
  Answer open_loop();
  Answer close_loop();
  /// lut.run will be started: restoring clears its table.
  void will_clear_lut() { lut_changed_ = true; }
  Answer clear_lut();

  /// Restores everything. Errors name what could not be restored, and how to do it.
  Answer restore();

 private:
  Answer again(const char* method, const nlohmann::json& params);

  const cli::Common& common_;
  nlohmann::json aberration_, correction_, loop_;
  bool poked_ = false, loop_closed_ = false, loop_changed_ = false, lut_changed_ = false;
};

}  // namespace ovws::check
