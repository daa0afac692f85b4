/// Provenance that depends on the machine; it is kept apart from results.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/result.hpp"

namespace ovws {

std::string host_name();

/// This process: its command line, host, processor, begin (UTC), duration so far, and
/// the time of all cores in it.
nlohmann::json host_facts();

/// Writes a JSON file, atomically. Errc::unavailable, field "output": it cannot be written.
Result<void> write_provenance(const nlohmann::json& facts, const std::filesystem::path& path);

/// The facts of the run that wrote this part, with the part's name; only the name if they are lost.
nlohmann::json facts_of_part(const std::filesystem::path& part);

}  // namespace ovws
