/// Program ovws: the command line. It sends requests to a daemon, and computes images and studies
/// offline.
#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <iostream>

#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/text/wrap.hpp"
#include "daemon/shared/client.hpp"
#include "daemon/shared/connection_options.hpp"
#include "proto/reader.hpp"

namespace ovws::cli {
namespace {

constexpr const char* kExitCodes =
    "Exit codes: 0 done; 1 the daemon or the command reported an error, or the\noutput cannot be "
    "written; 2 the command line is wrong; 3 no daemon answered in time.";

bool is_open(int descriptor) {
  return fcntl(descriptor, F_GETFD) != -1;
}

/// Opens /dev/null if standard input or error is closed. Otherwise a socket or file that is opened
/// later would get this descriptor and receive printed text. False: standard output is closed.
bool check_standard_streams() {
  for (const int descriptor : {0, 2}) {
    if (is_open(descriptor)) continue;
    const int null = open("/dev/null", O_RDWR);
    if (null != descriptor && null >= 0) {
      dup2(null, descriptor);
      close(null);
    }
  }
  return is_open(1);
}

/// Flushes standard output. Returns `status`, or kError if the output could not be written.
int end_output(int status) {
  std::cout.flush();
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout) return status;
  // A closed pipe is no error: its reader needed no more output.
  if (!output_has_no_reader())
    fmt::print(stderr,
               "ovws: standard output cannot be written, so it is incomplete: check the disk\n");
  return status == kOk ? kError : status;
}

/// Prints a command-line error, or the help if there is no command. Also handles --help and
/// --version, which CLI11 reports the same way.
int report_parse(const CLI::App& app, const CLI::ParseError& error) {
  const auto rest = app.remaining();
  const bool has_no_command = dynamic_cast<const CLI::RequiredError*>(&error) != nullptr &&
                              rest.empty() && app.get_subcommands().empty();
  if (has_no_command || dynamic_cast<const CLI::CallForHelp*>(&error) != nullptr) {
    constexpr std::size_t kHelpColumn = 30;
    print("{}\n", wrapped(app.help(), terminal_columns(), kHelpColumn));
    return has_no_command ? kUsage : kOk;
  }
  if (error.get_exit_code() == 0 || !app.get_subcommands().empty() || rest.empty() ||
      rest.front().starts_with('-')) {
    return app.exit(error) == 0 ? kOk : kUsage;
  }
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  const auto near = nearest_name(rest.front(), names);
  fmt::print(stderr, "ovws: unknown command {}{}\n", rest.front(),
             near ? "; did you mean " + *near + "?" : ": see ovws --help");
  return kUsage;
}

void add_common_options(CLI::App& app, Common& common) {
  app.require_subcommand(1);
  app.fallthrough();  // --json may also stand after the subcommand
  app.set_version_flag("--version", OVWS_VERSION);
  app.footer(kExitCodes);
  add_connection_options(app, common);
  app.add_flag("--json", common.json, "machine-readable output: one JSON object per line");
  app.add_option("--timeout", common.timeout_s, "how long to wait for a reply, s")
      ->capture_default_str()
      ->check(number_from(0.01, 3600.0));
}

int run(int argc, char** argv) {
  CLI::App app{"Optical Vortex Wavefront Sensor: command line"};
  Common common;
  add_common_options(app, common);
  int status = kOk;
  for (const auto add :
       {add_verbs, add_online_commands, add_call, add_watch, add_metrics, add_snapshot, add_doctor,
        add_check, add_setup, add_design, add_advise, add_pictures, add_measure, add_keygen,
        add_replay, add_export, add_study, add_merge}) {
    add(app, common, status);
  }
  add_completion(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return report_parse(app, error);
  } catch (const nlohmann::json::exception& error) {
    fmt::print(
        stderr,
        "ovws: the daemon's reply has an unknown format; check that ovws and ovwsd have the same "
        "version: {}\n",
        error.what());
    return kError;
  }
  return status;
}

}  // namespace

bool output_has_no_reader() {
  pollfd output{STDOUT_FILENO, 0, 0};
  return poll(&output, 1, 0) > 0 && (output.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0;
}

CLI::Validator number_from(double min, double max) {
  const auto check = [min, max](std::string& text) {
    double value = 0.0;
    const bool inside = CLI::detail::lexical_cast(text, value) && value >= min && value <= max;
    return inside ? std::string{} : fmt::format("{} is not a number from {} to {}", text, min, max);
  };
  return CLI::Validator(check, fmt::format("FLOAT in [{} - {}]", min, max));
}

}  // namespace ovws::cli

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);  // writes to a closed pipe then fail; end_output checks for it
  if (!ovws::cli::check_standard_streams()) {
    fmt::print(stderr, "ovws: standard output is closed\n");
    return ovws::cli::kError;
  }
  return ovws::cli::end_output(ovws::cli::run(argc, argv));
}
