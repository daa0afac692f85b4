/// What a recording keeps of the closed loop, so that its decisions can be repeated bit by bit.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>

#include "core/control/loop_model.hpp"
#include "core/control/loop_settings.hpp"
#include "core/optics/zernike.hpp"

namespace ovws {

/// Writes a document "loop" whenever the loop is closed: settings, first correction, and model. The
/// frames that the loop took, and its decisions, follow in documents "loop_steps". See
/// RECORDING.md. For one thread.
class LoopLog {
 public:
  using Write = std::function<void(std::string kind, nlohmann::json content)>;

  explicit LoopLog(Write write) : write_(std::move(write)) {}

  void closed(const LoopSettings& settings, std::span<const Mode> correction,
              const LoopModel* model);
  /// The laws observed a frame; `t_ns`: time of its residuals.
  void observed(std::uint64_t frame_id, std::int64_t t_ns);
  /// After that frame the laws computed the correction for `t_for_ns`, in the hologram
  /// `hologram_id`; 0: it could not be shown.
  void decided(std::int64_t t_for_ns, std::uint64_t hologram_id);
  void opened() { flush(); }

 private:
  void flush();

  Write write_;
  std::int64_t t_closed_ns_ = 0;
  nlohmann::json frames_ = nlohmann::json::array();
};

}  // namespace ovws
