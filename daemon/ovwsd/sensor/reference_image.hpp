/// Mean image of a reference: the average of some of the frames that its positions come from.
#pragma once

#include <memory>

#include "core/base/image.hpp"
#include "core/pipeline/frame_record.hpp"

namespace ovws {

/// Immutable once made.
struct ReferenceImage {
  int frames = 0;
  double gain_db = 0.0, gain_raw = kUnknownGain;  ///< see CameraSettings
  PixelFormat format = PixelFormat::mono8;
  Image<float> mean_dn;  ///< NaN where a frame had a pixel at the format's full scale
};

/// Message for a reference without a mean image.
constexpr const char* kNoImage =
    "the reference has no mean image; take it again with ten frames or more";

/// DN of 16 bits for a DN of this format.
double to_16_bits(PixelFormat format);
/// A mean image of frames of this format in 16 bits, which keep its fractions. A pixel that was
/// saturated is saturated.
Image<std::uint16_t> in_16_bits(const Image<float>& mean_dn, PixelFormat format);

/// The mean image of frames.
class ImageMean {
 public:
  /// A reference averages no more: its noise is then below that of the single frame which will be
  /// compared with it.
  static constexpr int kMaxFrames = 8;

  /// Returns false and ignores the frame if its size, format or gain differs from the first one's.
  bool add(const FrameRecord& record);
  /// Nothing if no frame was added. Call once.
  std::shared_ptr<const ReferenceImage> mean();

 private:
  ReferenceImage sum_;  ///< mean_dn holds the sum
};

}  // namespace ovws
