/// One output of one X server: its pixels, and the news that they changed. X headers stay in the
/// .cpp.
#pragma once

#include <memory>
#include <string>

#include "core/base/image.hpp"
#include "core/base/result.hpp"

namespace ovws::twin {

/// All calls from one thread, which is the only one in the program that uses X.
class XOutput {
 public:
  /// Errc::unavailable if there is no server, no such output, or it is off (the reason lists the
  /// outputs there are); Errc::refused if its mode is not width x height.
  static Result<std::unique_ptr<XOutput>> open(const std::string& display,
                                               const std::string& output, int width, int height);
  ~XOutput();
  XOutput(const XOutput&) = delete;
  XOutput& operator=(const XOutput&) = delete;

  int descriptor() const;  ///< readable when the server has something to say

  enum class News { none, pixels, lost };
  /// Takes in all that the server said. `lost`: the server died, or its screens were arranged
  /// anew; this object is of no more use.
  News read_news();
  News ask_news();  ///< the same, of all that happened before this call: one round trip

  /// The blue channel of each pixel, width x height. False if the server would not give them:
  /// then as `lost`.
  bool grab(Image<std::uint8_t>& grey);

 private:
  struct Impl;
  explicit XOutput(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws::twin
