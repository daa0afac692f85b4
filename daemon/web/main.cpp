/// ovws-web: the live page of the bench.
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdlib>
#include <optional>

#include "daemon/shared/client.hpp"
#include "daemon/shared/connection_options.hpp"
#include "daemon/shared/log.hpp"
#include "daemon/shared/service_notify.hpp"
#include "daemon/web/feeds.hpp"
#include "daemon/web/links.hpp"
#include "daemon/web/options.hpp"
#include "daemon/web/server.hpp"

namespace ovws::web {
namespace {

constexpr double kAnswerTimeoutS = 10.0;  ///< a camera may take seconds to change
constexpr double kPollTimeoutS = 2.0;
constexpr unsigned kExitTimeoutS = 1;

int report_error(const Error& error) {
  spdlog::error("{}", text_of(error));
  return cli::kError;
}

Result<Tokens> tokens_of(const Options& options) {
  if (options.links_path.empty()) return make_tokens(options.control);
  return keep_links(options.links_path, options.listen, options.control);
}

/// Forces the exit after kExitTimeoutS, so that pending calls to the daemon do not delay it.
void limit_exit_time() {
  std::signal(SIGALRM, [](int) { std::_Exit(cli::kOk); });
  ::alarm(kExitTimeoutS);
}

int serve(Options options) {
  if (auto usable = check_options(options); !usable) return report_error(usable.error());
  const auto tokens = tokens_of(options);
  if (!tokens) return report_error(tokens.error());
  const Access access(options.hosts(), *tokens);
  RefusalLog refusals;
  Board board;
  std::atomic<int> browsers{0};
  CommissionDesk commission(options.common);
  Tickets tickets;
  std::atomic<int> downloads{0};
  std::optional<Feeds> feeds;  // the server's pool may still use it at its end
  auto server =
      Server::listen(options.address, options.port,
                     {options.common, access, refusals, board,
                      [&feeds] { return feeds->hologram(); }, [&feeds] { return feeds->image(); },
                      [&feeds] { feeds->look_again(); }, commission, browsers, tickets, downloads});
  if (!server) return report_error(server.error());
  cli::Common polling = options.common;
  polling.timeout_s = kPollTimeoutS;
  feeds.emplace(polling, board, [&] { return ServerFacts{browsers, refusals.counts()}; });
  if (options.links_path.empty()) std::printf("%s", links_text(options.listen, *tokens).c_str());
  std::printf("ready http://%s/\n", options.listen.c_str());
  std::fflush(stdout);
  service::notify_ready();
  (*server)->run();
  service::notify_stopping();
  commission.end();  // a running step restores what it has changed
  limit_exit_time();
  return cli::kOk;
}

void add_options(CLI::App& app, Options& options) {
  app.set_version_flag("--version", OVWS_VERSION);
  options.common.timeout_s = kAnswerTimeoutS;
  cli::add_connection_options(app, options.common);
  app.add_option("--listen", options.listen, "address and port of the page")->capture_default_str();
  app.add_flag("--control", options.control,
               "also make a link for control; without it pages are for viewing only");
  app.add_option(
      "--links", options.links_path,
      "file (mode 0600) that keeps the links over a restart (default: make and print new "
      "links at each start)");
  app.add_option(
      "--allow-host", options.more_hosts,
      "further HOST or HOST:PORT by which browsers reach this page, e.g. a proxy's name");
  app.add_flag("--cleartext", options.cleartext,
               "allow an address that other machines can reach, although others on the network can "
               "read the links' tokens");
}

}  // namespace
}  // namespace ovws::web

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);
  ::umask(S_IRWXG | S_IRWXO);
  CLI::App app{"The live page of an Optical Vortex Wavefront Sensor"};
  ovws::web::Options options;
  ovws::web::add_options(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? ovws::cli::kOk : ovws::cli::kUsage;
  }
  ovws::start_log(ovws::LogLevel::info);
  return ovws::web::serve(options);
}
