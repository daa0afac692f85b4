/// Mean image of a reference: the average of some of the frames that give the reference positions.
#pragma once

#include <memory>

#include "core/base/image.hpp"
#include "core/pipeline/frame_record.hpp"

namespace ovws {

/// Mean image and the camera settings of its frames. Immutable once made.
struct ReferenceImage {
  int frames = 0;
  double gain_db = 0.0, gain_raw = kUnknownGain;  ///< see CameraSettings
  PixelFormat format = PixelFormat::mono8;
  Image<float> mean_dn;  ///< NaN where the pixel was at full scale in any frame
};

/// Message for a reference without a mean image.
constexpr const char* kNoImage =
    "the reference has no mean image; take it again with ten frames or more";

/// Scale factor from DN of this format to DN of 16 bits.
double to_16_bits(PixelFormat format);
/// Converts a mean image of frames of this format to 16 bits, to keep fractions of a DN. A pixel
/// that was saturated in any frame gets 65535.
Image<std::uint16_t> in_16_bits(const Image<float>& mean_dn, PixelFormat format);

/// Averages frames to a mean image.
class ImageMean {
 public:
  /// Number of frames that a reference averages at most. More are of little use: the mean image is
  /// compared with single frames, whose noise then dominates.
  static constexpr int kMaxFrames = 8;

  /// Returns false and ignores the frame if its size, format or gain differs from the first one's.
  bool add(const FrameRecord& record);
  /// Returns the mean image, or null if no frame was added. Call once: the sum is moved out.
  std::shared_ptr<const ReferenceImage> mean();

 private:
  ReferenceImage sum_;  ///< mean_dn holds the sum of the frames, not yet the mean
};

}  // namespace ovws
