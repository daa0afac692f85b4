/// Results of methods in a few lines for people.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace ovws::cli {

/// Summary of a result of `method`, or of the result of a job that it started. A sentence for what
/// the lab asks daily; for everything else one line per key. Without a final newline. Throws
/// nlohmann::json::exception if the result is not one of this version of the daemon.
std::string answer_text(const std::string& method, const nlohmann::json& result);

/// One line per key, sorted, with the path of a nested key. Long lists are given by their length.
/// Leaves out nulls, empty values, and keys that only programs need.
std::string summary_text(const nlohmann::json& result);

/// "12:03:04 warning loop: the loop opened …", in local time, of an event message.
std::string event_text(const nlohmann::json& event);

// Sentences that other texts use, too.

/// "exposure 2 ms, gain 0 dB, 100 frames/s, Mono8, region 512 x 512 at (0, 0)"; `settings`: of the
/// camera.
std::string camera_settings_text(const nlohmann::json& settings);
/// "2 ms" with the limits of the camera, if they are known.
std::string exposure_text(const nlohmann::json& settings, const nlohmann::json& limits);
std::string gain_text(const nlohmann::json& settings, const nlohmann::json& limits);
std::string rate_text(const nlohmann::json& settings, const nlohmann::json& limits);
/// "0.2062 wave RMS, vertical coma +0.2000, …" of a list of named modes; empty: all are 0.
std::string modes_text(const nlohmann::json& modes);
/// "measured 12 min ago from 100 frames", of a result of reference.get.
std::string reference_text(const nlohmann::json& reference);
/// "closed, 120 steps, …", of a result of loop.get.
std::string loop_text(const nlohmann::json& loop);
/// "run-1.h5: 12 s, 1200 frames, …", of a result of record.get.
std::string record_text(const nlohmann::json& record);

}  // namespace ovws::cli
