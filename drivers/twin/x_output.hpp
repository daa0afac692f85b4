/// Reader of one X server output: its pixels, and notification of changes (DAMAGE extension). This
/// header includes no X headers.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/base/result.hpp"

namespace ovws::twin {

/// Output of an X server. One thread makes all calls; no other thread may use Xlib.
class XOutput {
 public:
  /// Opens the output for reading. Errc::unavailable if there is no server, no such output, or the
  /// output is off (the reason lists the active outputs), or if the server lacks an extension.
  /// Errc::refused if the output does not show width x height pixels.
  static Result<std::unique_ptr<XOutput>> open(const std::string& display,
                                               const std::string& output, int width, int height);
  ~XOutput();
  XOutput(const XOutput&) = delete;
  XOutput& operator=(const XOutput&) = delete;

  int descriptor() const;  ///< file descriptor; readable when the server has sent events

  enum class Change { none, pixels, lost };
  /// Processes all received events. `lost`: the server ended or rearranged its screens; destroy
  /// this object and open the output again.
  Change read_changes();
  /// Makes a round trip to the server, then read_changes: includes all changes before this call.
  Change sync_changes();
  /// When the server made the earliest change that read_changes last reported, by its own clock
  /// (1 ms): a process that has waited for a processor reads of it late.
  std::chrono::steady_clock::time_point changed_at() const;

  /// Reads the pixels, 0x00RRGGBB: calls visit_row(pixels, y) for each row. False if the server
  /// refuses; then treat the output as `lost`.
  bool grab(const std::function<void(const std::uint32_t* pixels, int y)>& visit_row);

 private:
  struct Impl;
  explicit XOutput(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws::twin
