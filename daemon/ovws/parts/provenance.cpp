#include "daemon/ovws/parts/provenance.hpp"

#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <ctime>
#include <fstream>
#include <sstream>
#include <vector>

#include "daemon/shared/atomic_file.hpp"
#include "proto/json_text.hpp"

namespace ovws {
namespace {

using Clock = std::chrono::steady_clock;

const Clock::time_point kBegun = Clock::now();
const std::time_t kBegunUtc = std::time(nullptr);

std::string content_of(const std::filesystem::path& path) {
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

std::vector<std::string> command_line() {
  std::vector<std::string> words;
  std::stringstream text(content_of("/proc/self/cmdline"));
  for (std::string word; std::getline(text, word, '\0');) words.push_back(word);
  return words;
}

std::string processor() {
  std::stringstream text(content_of("/proc/cpuinfo"));
  for (std::string line; std::getline(text, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

}  // namespace

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

nlohmann::json host_facts() {
  return {{"command", command_line()},
          {"host", host_name()},
          {"processor", processor()},
          {"begun_utc", fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(kBegunUtc))},
          {"took_s", std::chrono::duration<double>(Clock::now() - kBegun).count()},
          {"cpu_s", double(std::clock()) / CLOCKS_PER_SEC}};
}

Result<void> write_provenance(const nlohmann::json& facts, const std::filesystem::path& path) {
  auto written = replace_file(path, json_text(facts, 2) + "\n");
  if (written) return {};
  return fail(Errc::unavailable, "output", written.error().reason);
}

nlohmann::json facts_of_part(const std::filesystem::path& part) {
  nlohmann::json facts =
      json_of(content_of(std::filesystem::path(part).replace_extension(".host.json")));
  if (!facts.is_object()) facts = nlohmann::json::object();
  facts["part"] = part.filename().string();
  return facts;
}

}  // namespace ovws
