/// Questions of `ovws doctor` about this machine: configuration, camera, display, state folder and
/// host. A `read_…` gathers facts and changes nothing; `answers` judges them. No daemon is needed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "daemon/examine/finding.hpp"
#include "daemon/ovwsd/settings/key_file_check.hpp"
#include "drivers/aravis/aravis_camera.hpp"
#include "drivers/aravis/camera_link.hpp"
#include "drivers/aravis/gige_probe.hpp"
#include "drivers/aravis/listing.hpp"
#include "drivers/sdl/display_probe.hpp"
#include "drivers/sdl/sdl_display.hpp"

namespace ovws::examine {

// Configuration: the file loads, describes a usable sensor, and its keys are readable.

struct ConfigurationFacts {
  std::string path;              ///< file to load; empty: none is named, and the service has none
  std::optional<Config> config;  ///< the defaults if there is no file; none: loading failed
  std::optional<Error> error;    ///< why `config` is missing or unusable
  std::optional<Error> unseen;   ///< why a daemon would find no spots with this configuration
  std::optional<Error> zeroth_order;  ///< why it disturbs; none: it is outside the region
  std::string daemon;                 ///< endpoint of the daemon whose settings `config`, `unseen`
                                      ///< and `zeroth_order` are about; empty: those of the file
  std::string rejected;               ///< path of saved values that were set aside; empty: none
  KeyFileCheck keys;
  std::string saved;             ///< saved settings as text (describe_saved); empty: none
  bool saved_is_unused = false;  ///< the saved values are damaged, or of another configuration file
};

/// Loads the configuration file at `path`. With an empty `path`: the service's file, or the
/// defaults if the service has no file.
ConfigurationFacts read_configuration(const std::string& path);
/// Replaces what is judged by the settings that a running daemon uses. What was found about the
/// file stays.
void judge_instead(ConfigurationFacts& facts, const Config& in_use, const std::string& endpoint);
Findings answers(const ConfigurationFacts& facts);

// Camera: presence, control, and the capacity of the link to it.

/// Whether a daemon answered (`silent`: none did), and whether it has the camera open (`with`) or
/// not (`without`).
enum class DaemonsCamera { silent, without, with };

struct CameraFacts {
  CameraConfig config;
  DaemonsCamera daemon = DaemonsCamera::silent;
  std::vector<ListedCamera>
      listed;  ///< found by discovery; empty if camera.id is an address that answered
  std::optional<ListedCamera> camera;  ///< the camera that camera.id names; none: not found
  std::optional<GigeAnswer> answer;    ///< GigE only: what the camera reports
  std::optional<NetworkPath> path;     ///< GigE only: the route to the camera
  std::optional<int> usb_mbps;         ///< USB only: the speed of the camera's port
  std::optional<std::int64_t> usbfs_mb;
  std::optional<std::int64_t> rmem_max_bytes;
  int buffers = AravisConfig{}.buffers;
  std::int64_t socket_buffer_bytes = AravisConfig{}.socket_buffer_bytes;
};

/// Finds the camera and reads the host's limits. Takes about 1 s; never takes control of a camera.
CameraFacts read_camera(const CameraConfig& config, DaemonsCamera daemon);
Findings answers(const CameraFacts& facts);

// Display: the SLM's X output, its mode, and interference by the desktop.

struct DisplayFacts {
  SdlConfig config;
  Result<sdl::DisplayProbe> probe;
  bool server_named = false;  ///< the environment variable DISPLAY is set
  bool daemon_shows = false;  ///< a daemon that answers has the SLM's output open
};

/// Probes the X server. Takes up to 3 s if it does not answer; call it once per process. Opens no
/// window. `daemon_shows`: see DisplayFacts.
DisplayFacts read_display(const SlmConfig& config, bool daemon_shows);
Findings answers(const DisplayFacts& facts);

// State folder: whether measurements survive a restart.

struct StateFacts {
  std::optional<std::string> directory;  ///< none: not configured, and no service's folder exists
  bool of_daemon = false;                ///< `directory` is what the running daemon reports
  bool there = false;
  bool is_folder = false;
  bool writable = false;  ///< by this user; before creation: the nearest existing parent
  bool disk_writable = true;
  std::string owner;             ///< user name of the owner; empty: this user
  std::uint64_t free_bytes = 0;  ///< free space on the directory's disk, available without root
};

/// Reads the facts about the state directory of a configuration from the file `path` (empty: from
/// none). Writes nothing, not even a test file.
StateFacts read_state(const StateConfig& config, const std::string& path);
/// The same about the folder that a running daemon uses; none: it uses none.
StateFacts read_state_of_daemon(const std::optional<std::string>& folder);
Findings answers(const StateFacts& facts);

// Host: real-time limits, CPU power management and the clock.

/// Resource limits of a process: real-time priority (RLIMIT_RTPRIO) and locked memory.
struct Limits {
  std::uint64_t realtime_priority = 0;
  std::optional<std::uint64_t> locked_bytes = 0;  ///< none: unlimited
  bool may_any_priority = false;                  ///< CAP_SYS_NICE
  bool may_lock_all = false;                      ///< CAP_IPC_LOCK
};

enum class Access { absent, refused, given };

struct HostFacts {
  RealtimePolicy policy = RealtimePolicy::ignore;
  std::optional<Limits> limits;
  bool of_service = false;  ///< `limits` are those of the running service; else of this process
  std::optional<std::int64_t> rt_runtime_us, rt_period_us;
  std::vector<std::string> governors;  ///< distinct names of CPU governors; empty: no scaling
  Access dma_latency = Access::absent;
  std::optional<std::string> clock_source;
  std::optional<bool> clock_synchronised;
};

/// Parses the texts of /proc/PID/limits and /proc/PID/status; none: unexpected format.
std::optional<Limits> parse_limits(std::string_view limits, std::string_view status);

HostFacts read_host(RealtimePolicy policy);
Findings answers(const HostFacts& facts);

// The kernel's files in /proc and /sys.

/// Whole text of the file; none: the file does not exist or cannot be read.
std::optional<std::string> text_of(const std::string& path);
/// First word of the file; none: the file is empty or cannot be read.
std::optional<std::string> word_of(const std::string& path);
/// First word of the file as a whole number; none: it is no number, or the file cannot be read.
std::optional<std::int64_t> number_of(const std::string& path);

}  // namespace ovws::examine
