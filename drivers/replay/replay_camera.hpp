/// Camera driver that replays the images of a recording, at any frame rate.
#pragma once

#include <memory>
#include <string>

#include "core/port/camera.hpp"

namespace ovws {

/// Opens a recording. Errors, field "camera.id": those of RecordingReader::open, and Errc::invalid
/// for a recording without images.
///
/// In addition to what the interface Camera guarantees:
/// - Region and pixel format are the recording's; other values are refused. Gain and exposure are
///   always those of the recording's first frame with known settings. `frame_rate_hz` is the replay
///   rate; the recording's own rate gives the original speed.
/// - After the last image the replay continues with the first image; frame numbers continue to
///   rise.
/// - Timestamps are those of the replay. Frames missing in the recording are missing in the replay,
///   too.
Result<std::unique_ptr<Camera>> open_replay_camera(const std::string& path);

}  // namespace ovws
