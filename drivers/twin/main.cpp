/// ovws-twin, the digital twin of the bench: starts all parts, prints `ready`, and runs until
/// SIGINT or SIGTERM.
#include <signal.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>

#include "drivers/twin/twin.hpp"

namespace {

/// Blocks SIGINT and SIGTERM before any thread exists, so that only sigwait receives them.
sigset_t block_end_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

int refuse(const ovws::Error& error) {
  std::cerr << "ovws-twin: " << ovws::text_of(error) << "\n";
  return 1;
}

int run(const ovws::twin::Config& config, const std::string& x_display) {
  const sigset_t end_signals = block_end_signals();
  auto twin = ovws::twin::Twin::start(config, x_display);
  if (!twin) return refuse(twin.error());
  std::cout << "ready " << (*twin)->addresses() << std::endl;
  int signal_number = 0;
  sigwait(&end_signals, &signal_number);
  spdlog::info("stops on signal {}", signal_number);
  // Exit after 2 s in any case: Xlib may wait forever for an X server that does not respond.
  std::signal(SIGALRM, [](int) { _exit(0); });
  alarm(2);
  return 0;
}

int start(int argc, char** argv) {
  CLI::App app{"Digital twin of the ovws bench: reads the SLM's display and answers as its camera"};
  std::string config_path, address, control, x_display;
  app.add_option("--config", config_path, "JSON configuration file (default: built-in values)");
  app.add_option("--address", address, "IPv4 address of the camera (UDP port 3956)");
  app.add_option("--control", control,
                 "ZeroMQ endpoint of the control socket (ground truth and faults)");
  app.add_option("--display", x_display, "X display (default: $DISPLAY)");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  spdlog::set_default_logger(spdlog::stderr_color_mt("ovws-twin"));

  auto config =
      config_path.empty() ? ovws::twin::parse_config("{}") : ovws::twin::load_config(config_path);
  if (!config) return refuse(config.error());
  if (!address.empty()) config->camera.address = address;
  if (!control.empty()) config->control_endpoint = control;
  return run(*config, x_display);
}

}  // namespace

int main(int argc, char** argv) try { return start(argc, argv); } catch (const std::exception& e) {
  std::fprintf(stderr, "ovws-twin: %s\n", e.what());
  return 1;
}
