/// Reader of one X server output: its pixels, and notification of changes (DAMAGE extension). X
/// headers stay in the .cpp.
#pragma once

#include <memory>
#include <string>

#include "core/base/image.hpp"
#include "core/base/result.hpp"

namespace ovws::twin {

/// All calls from one thread, the only one in the program that uses Xlib.
class XOutput {
 public:
  /// Errc::unavailable if there is no server, no such output, or it is off (the reason lists the
  /// outputs there are); Errc::refused if its mode is not width x height.
  static Result<std::unique_ptr<XOutput>> open(const std::string& display,
                                               const std::string& output, int width, int height);
  ~XOutput();
  XOutput(const XOutput&) = delete;
  XOutput& operator=(const XOutput&) = delete;

  int descriptor() const;  ///< readable when the server has sent events

  enum class Change { none, pixels, lost };
  /// Processes all received events. `lost`: the server died or its screens were rearranged; the
  /// object can no longer be used.
  Change read_changes();
  Change sync_changes();  ///< the same after a round trip, so that all earlier changes are included

  /// Reads the blue channel of each pixel, width x height. False if the server refuses: then as
  /// `lost`.
  bool grab(Image<std::uint8_t>& grey);

 private:
  struct Impl;
  explicit XOutput(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws::twin
