/// A recording as a camera: its pictures come as they came, at any pace.
#pragma once

#include <memory>
#include <string>

#include "core/port/camera.hpp"

namespace ovws {

/// Errors as of RecordingReader::open, and Errc::invalid of a recording without pictures, field
/// "camera.id".
///
/// What this driver adds to the port's promises:
/// - Region and format are the recording's, others are refused. Gain and exposure become those of
///   the recording's first frame: it has no others. `frame_rate_hz` is the pace: that of the
///   recording is its original speed.
/// - After the last picture the first one comes again, with numbers that go on rising.
/// - Stamps are those of the replay. Frames that the recording lacks are lacking here, too.
Result<std::unique_ptr<Camera>> open_replay_camera(const std::string& path);

}  // namespace ovws
