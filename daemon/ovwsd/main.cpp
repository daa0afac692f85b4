/// ovwsd: the daemon.
#include <fcntl.h>
#include <malloc.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <csignal>
#include <cstdio>

#include "daemon/ovwsd/access/client_guard.hpp"
#include "daemon/ovwsd/app.hpp"
#include "daemon/ovwsd/settings/config_check.hpp"
#include "daemon/ovwsd/settings/key_file_check.hpp"
#include "daemon/ovwsd/settings/saved_config.hpp"
#include "daemon/ovwsd/threads/thread_plan.hpp"
#include "daemon/shared/log.hpp"

namespace {

constexpr int kUsage = 2;
constexpr const char* kExitCodes =
    "Exit codes: 0 ended by a signal, or the configuration is valid; 1 the configuration is not "
    "valid, the\nstart failed, or a fatal error ended the daemon; 2 the command line is wrong.";

std::atomic<bool> stop_requested{false}, reload_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler sets them");

void request_stop(int /*signal*/) {
  stop_requested.store(true);
}

void request_reload(int /*signal*/) {
  reload_requested.store(true);
}

int log_failure(const ovws::Error& error) {
  spdlog::error("{}", ovws::text_of(error));
  return 1;
}

/// File descriptors 0 to 2: opens /dev/null for each closed one, so that no other file takes the
/// place of standard input, output or the log. Raises the limit of open files (RLIMIT_NOFILE) to
/// its maximum, because each client needs a descriptor.
void prepare_descriptors() {
  int fd = ::open("/dev/null", O_RDWR);
  while (fd >= 0 && fd <= STDERR_FILENO) fd = ::open("/dev/null", O_RDWR);
  if (fd > STDERR_FILENO) ::close(fd);
  rlimit files{};
  if (::getrlimit(RLIMIT_NOFILE, &files) != 0) return;
  files.rlim_cur = files.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &files);
}

/// Fixes malloc's mmap threshold, so that freed large blocks return to the system. Without it
/// glibc's per-thread arenas, which are locked memory (mlockall), grow to 150 MiB after some
/// minutes of mixed commands. With large blocks mapped one by one the arenas stay at a third.
/// Call once, before any thread is created.
void set_malloc_thresholds() {
  constexpr int kLargeBytes = 128 << 10;  // glibc's initial value; setting it disables adaptation
  constexpr int kSpareBytes = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, kLargeBytes);
  mallopt(M_TRIM_THRESHOLD, kSpareBytes);
}

/// Logs which saved settings are active, or a warning if the saved settings cannot be used.
void report_saved(const ovws::LoadedConfig& loaded) {
  const std::string saved = ovws::describe_saved(loaded);
  if (saved.empty()) return;
  spdlog::log(loaded.unused_reason.empty() ? spdlog::level::info : spdlog::level::warn, saved);
}

/// Checks the key files named in the section `security`. Returns false and logs the error if the
/// daemon could not use the files. Warns if the current user may not read the secret key.
bool has_usable_key_files(const std::string& path, const ovws::Config& config) {
  const ovws::KeyFileCheck keys = ovws::check_key_files(path, config);
  if (keys.error) {
    ovws::Error error = *keys.error;
    if (!keys.fix.empty()) error.reason += "; fix: " + keys.fix;
    log_failure(error);
    return false;
  }
  if (!keys.read) {
    spdlog::warn(
        "security.secret_key: not checked, because this user may not read it; run: sudo -u {} "
        "ovwsd --check-config --config {}",
        keys.user, path);
  }
  return true;
}

int check(const std::string& path, const ovws::LoadedConfig& loaded) {
  const ovws::Config& config = loaded.effective;
  if (!has_usable_key_files(path, config)) return 1;
  report_saved(loaded);
  if (const auto seen = ovws::check_sees_spots(config); !seen) return log_failure(seen.error());
  if (const auto dark = ovws::check_zeroth_order(config); !dark) {
    spdlog::warn(ovws::text_of(dark.error()));
  }
  spdlog::info("{} is valid", path.empty() ? "the default configuration" : path);
  std::printf("%s\n", ovws::dump_config(config).c_str());
  return 0;
}

int serve(ovws::LoadedConfig loaded) {
  if (const auto safe = ovws::check_security(loaded.effective); !safe) {
    return log_failure(safe.error());
  }
  ovws::set_aside_if_invalid(loaded);
  report_saved(loaded);
  std::signal(SIGTERM, request_stop);
  std::signal(SIGINT, request_stop);
  std::signal(SIGPIPE, SIG_IGN);
  return ovws::run_daemon(loaded, stop_requested, reload_requested) ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  ovws::keep_stacks_small();
  set_malloc_thresholds();
  prepare_descriptors();
  ::umask(::umask(0) | S_IWOTH);  // no socket file may ever be writable by other users
  CLI::App line{"Real-time daemon for the Optical Vortex Wavefront Sensor"};
  std::string path;
  bool check_only = false;
  line.add_option("--config,-c", path, "configuration file; without it, every key has its default");
  line.add_flag("--check-config", check_only,
                "check the configuration, print it with the saved settings, and exit");
  line.set_version_flag("--version", OVWS_VERSION);
  line.footer(kExitCodes);
  std::signal(SIGHUP, request_reload);  // by default it would end a daemon that still starts
  try {
    line.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return line.exit(error) == 0 ? 0 : kUsage;
  }

  const auto loaded =
      ovws::load_with_saved(path, check_only ? ovws::service_state_folder(path) : std::nullopt);
  ovws::start_log(loaded ? loaded->effective.log.level : ovws::LogLevel::info);
  if (!loaded) return log_failure(loaded.error());
  if (const auto usable = ovws::check_usable(loaded->effective); !usable) {
    return log_failure(usable.error());
  }
  return check_only ? check(path, *loaded) : serve(*loaded);
}
