/// ovws: talk to a daemon, watch it, and make the sensor's pictures without one.
#include <CLI/CLI.hpp>

#include "daemon/cli/commands.hpp"

int main(int argc, char** argv) {
  CLI::App app{"Optical Vortex Wavefront Sensor: command line"};
  app.require_subcommand(1);
  app.fallthrough();  // --json may also stand after the subcommand
  app.set_version_flag("--version", OVWS_VERSION);
  ovws::cli::Common common;
  app.add_option("--endpoint", common.endpoint, "control endpoint of the daemon")
      ->capture_default_str();
  app.add_flag("--json", common.json, "machine-readable: one JSON a line");
  app.add_option("--timeout", common.timeout_s, "how long to wait for an answer, s")
      ->capture_default_str()
      ->check(CLI::Range(0.01, 3600.0));

  int status = 0;
  ovws::cli::add_status(app, common, status);
  ovws::cli::add_describe(app, common, status);
  ovws::cli::add_call(app, common, status);
  ovws::cli::add_watch(app, common, status);
  ovws::cli::add_snapshot(app, common, status);
  ovws::cli::add_hologram(app, common, status);
  ovws::cli::add_farfield(app, common, status);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : ovws::cli::kUsage;
  }
  return status;
}
