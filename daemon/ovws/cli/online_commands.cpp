#include "daemon/ovws/cli/command_line.hpp"

#include <CLI/CLI.hpp>
#include <limits>
#include <memory>

#include "daemon/ovws/cli/commands.hpp"

namespace ovws::cli {
namespace {

constexpr const char* kParamsHelp =
    "Dots in a KEY nest. A list is written as 3,4,5 or as JSON. Lists of modes\n"
    "also accept LIST.MODE=NUMBER:\n"
    "  ovws call aberration.set modes.vertical-coma=0.2 modes.4=-0.1\n"
    "  ovws call loop.close modes=defocus,primary-spherical\n"
    "MODE is the OSA/ANSI index j, a name, or (not in a list with commas) n,m.\n"
    "Words of a name can be left out while it stays unique: spherical is\n"
    "primary-spherical. coma is refused, because it can be vertical-coma or\n"
    "horizontal-coma.";

void add_status(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand(
      "status", "show the state of the bench: camera, SLM, reference, wavefront, loop, recording");
  command->callback([&common, &status] { status = show_status(common); });
}

void add_describe(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand(
      "describe",
      "list every method and stream of the daemon, or explain one: its keys with ranges, and "
      "examples (with --json: their schemas)");
  auto name = std::make_shared<std::string>();
  command->add_option("name", *name, "method or stream, e.g. camera.set");
  command->callback([&common, &status, name] { status = describe(common, *name); });
}

void add_call(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand(
      "call",
      "call any method of the daemon, e.g. ovws call camera.set exposure_us=2000 roi.width=512");
  command->footer(kParamsHelp);
  auto options = std::make_shared<CallOptions>();
  command->add_option("method", options->method, "name of the method; ovws describe lists all")
      ->required();
  command->add_option(
      "params", options->params,
      "KEY=VALUE, a JSON object, @FILE with a JSON object, or - for one on standard "
      "input; later words override earlier ones");
  command->add_flag(
      "--wait,-w", options->wait,
      "if the method starts a job, wait for its end and print its result, or why it failed; on a "
      "terminal also show its progress");
  command->callback([&common, &status, options] { status = call_method(common, *options); });
}

void add_watch(CLI::App& app, const Common& common, int& status) {
  auto* command =
      app.add_subcommand("watch",
                         "show the bench full-screen (press ? for help). Piped, or with --plain or "
                         "-n: the topics wavefront and refined as a table, and on a terminal event "
                         "as one line per event. With --json, and otherwise: one JSON object per "
                         "line. With --timeout: end if no message "
                         "arrives for that long");
  auto options = std::make_shared<WatchOptions>();
  command->add_option("topic", options->topic, "stream")
      ->check(CLI::IsMember(
          {"wavefront", "refined", "spots", "corrector", "image", "phase", "status", "event"}))
      ->capture_default_str();
  command->add_option("-n,--count", options->count, "end after this many messages; 0: never")
      ->check(CLI::Range(0, std::numeric_limits<int>::max()));
  command->add_flag("--plain", options->plain, "print a table on a terminal too");
  command->callback([&app, &common, &status, options] {
    if (app.count("--timeout") > 0) options->timeout_s = common.timeout_s;
    status = watch(common, *options);
  });
}

void add_metrics(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand(
      "metrics",
      "serve the daemon's metrics to Prometheus (http://ADDRESS:PORT/metrics) until Ctrl-C; "
      "reconnects when the daemon restarts");
  auto address = std::make_shared<std::string>("127.0.0.1:7705");
  command
      ->add_option("--listen", *address,
                   "ADDRESS:PORT with a numeric loopback address, because metrics need no key")
      ->envname("OVWS_METRICS_LISTEN")
      ->capture_default_str();
  command->callback([&common, &status, address] { status = serve_metrics(common, *address); });
}

void add_snapshot(CLI::App& app, const Common& common, int& status) {
  auto* command =
      app.add_subcommand("snapshot",
                         "write the camera image with its spots and the wavefront as PNG; waits up "
                         "to --timeout for a valid frame");
  auto prefix = std::make_shared<std::string>("ovws");
  command
      ->add_option("--output,-o", *prefix,
                   "prefix of the files PREFIX-camera.png and PREFIX-phase.png, or a folder")
      ->capture_default_str();
  command->callback([&common, &status, prefix] { status = save_snapshot(common, *prefix); });
}

void add_doctor(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand("doctor",
                                     "check this bench in a few seconds and print a fix for each "
                                     "problem; read-only, works with or "
                                     "without a daemon, needs no root");
  command->footer(
      "Checks the configuration, the camera and its link, the SLM's output, the state folder,\n"
      "the real-time limits and the clock of this machine, and the daemon if one is running.\n"
      "It judges the settings that the daemon uses, or a file; \"configuration\" says which.\n"
      "Run it as the daemon's user, on its display:\n"
      "  sudo -u ovws DISPLAY=:0 XAUTHORITY=/var/lib/ovws/xauthority ovws doctor\n\n"
      "Each finding is FAULT (does not work, or measures wrongly), warning (works or may work, "
      "but\n"
      "worse than it could), ok, or not here (cannot be checked, with the reason). \"fix:\" is "
      "followed\n"
      "by a shell command or a line for the configuration file.\n"
      "--json prints one document: {\"schema\", \"version\", \"counts\": {\"fault\", …}, "
      "\"findings\":\n"
      "[{\"name\", \"verdict\": \"fault\" | \"warning\" | \"ok\" | \"not_here\", \"meaning\", "
      "\"fix\"}]}.\n\n"
      "Exit codes: 0 no fault; 1 at least one fault; 2 the command line is wrong.");
  auto path = std::make_shared<std::string>();
  command->add_option(
      "--config,-c", *path,
      "configuration file to judge (default: the settings that the daemon on this machine uses; if "
      "none answers, /etc/ovws/ovwsd.json; if there is none, every key's default)");
  const CLI::Option* const given = app.get_option("--endpoint");
  command->callback([&common, &status, path, given] {
    status = check_bench(common, *path, given->count() > 0 ? common.endpoint : "");
  });
}

}  // namespace

void add_online_commands(CLI::App& app, const Common& common, int& status) {
  add_status(app, common, status);
  add_describe(app, common, status);
  add_call(app, common, status);
  add_watch(app, common, status);
  add_metrics(app, common, status);
  add_snapshot(app, common, status);
  add_doctor(app, common, status);
}

}  // namespace ovws::cli
