/// The reference as a picture: the mean of some frames that a reference's positions were taken
/// from.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>

#include "core/base/image.hpp"
#include "daemon/ovwsd/frames/frame_taker.hpp"

namespace ovws {

/// Immutable once made.
struct ReferencePicture {
  int frames = 0;
  double gain_db = 0.0, gain_raw = kNotKnown;  ///< see CameraSettings
  PixelFormat format = PixelFormat::mono8;
  Image<float> mean_dn;  ///< NaN where a frame had a pixel at the format's full scale
};

/// Why a reference holds none, and the way out.
constexpr const char* kNoPicture = "it holds no picture; take it anew, from ten frames or more";

/// Of one image, whose gain is not known.
ReferencePicture picture_of(const ImageView& image);

/// Averages while a reference is taken. `begin`, `end` and `cancel` from any thread.
class ReferencePictureTaker : public FrameTaker {
 public:
  /// Frames beyond these are left to their purpose: their noise is already below that of the single
  /// frame which will be compared with the mean.
  static constexpr int kMostFrames = 8;

  /// From now on frames during which this hologram stood still, measured with a plan of this epoch,
  /// are averaged: at most `most` of them.
  void begin(std::uint64_t sensor_epoch, std::uint64_t hologram_id, int most = kMostFrames);
  /// The mean so far, and no more frames; nullptr if there was none.
  std::shared_ptr<const ReferencePicture> end();
  void cancel() { end(); }
  int frames();  ///< averaged so far; 0 if nothing is being taken

  bool wants() override;
  void take(const FrameRecord& record) override;

 private:
  std::mutex mutex_;
  std::uint64_t sensor_epoch_ = 0;
  std::uint64_t hologram_id_ = 0;
  int most_ = 0;
  std::unique_ptr<ReferencePicture> sum_;  ///< mean_dn holds the sum; none: nothing is being taken
};

}  // namespace ovws
