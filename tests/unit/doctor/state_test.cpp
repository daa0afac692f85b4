#include "daemon/examine/machine/machine.hpp"

#include <filesystem>
#include <fstream>

#include "tests/support/own_folder.hpp"
#include "tests/unit/doctor/expect.hpp"

namespace ovws::examine {
namespace {

StateFacts good() {
  StateFacts facts;
  facts.directory = "/var/lib/ovws";
  facts.there = facts.is_folder = facts.writable = true;
  facts.free_bytes = 10ULL << 30;
  return facts;
}

TEST(DoctorState, AMissingFolderIsAFaultOnlyIfItCannotBeCreated) {
  expect(good(), "state.directory", Severity::good);
  expect(good(), "state.room", Severity::good);
  auto facts = good();
  facts.there = facts.is_folder = false;
  expect(facts, "state.directory", Severity::good);
  facts.writable = false;
  expect(facts, "state.directory", Severity::bad, "install -d -o ovws -g ovws /var/lib/ovws");
  expect(StateFacts{}, "state.directory", Severity::warning, "\"state\": {\"directory\"");
  expect(StateFacts{}, "state.room", Severity::not_here);
  EXPECT_EQ(read_state({}, "my.json").directory, std::nullopt) << "the service's is not its own";
}

TEST(DoctorState, AnUnwritableFolderIsAFaultWithTheRepairForItsOwner) {
  auto facts = good();
  facts.writable = false;
  expect(facts, "state.directory", Severity::bad, "chmod u+rwx /var/lib/ovws");
  facts.directory = "/srv/it's; reboot";
  expect(facts, "state.directory", Severity::bad, "chmod u+rwx '/srv/it'\\''s; reboot'");
  facts.owner = "ovws";
  expect(facts, "state.directory", Severity::not_here, "sudo -u ovws ovws doctor");
  facts.disk_writable = false;
  expect(facts, "state.directory", Severity::bad, "remount,rw");
  facts = good();
  facts.is_folder = false;
  expect(facts, "state.directory", Severity::bad);
}

TEST(DoctorState, TheFolderOfARunningDaemonIsWhatItReports) {
  auto facts = good();
  facts.of_daemon = true;
  expect(facts, "state.directory", Severity::good);
  facts.writable = false;
  facts.owner = "ovws";
  expect(facts, "state.directory", Severity::good);
  facts.there = facts.is_folder = false;
  expect(facts, "state.directory", Severity::not_here);
  expect(facts, "state.room", Severity::not_here);
  facts = good();
  facts.of_daemon = true;
  facts.directory = "state";  // relative to the daemon's folder
  expect(facts, "state.directory", Severity::not_here);
  expect(read_state_of_daemon(std::nullopt), "state.directory", Severity::not_here);
}

TEST(DoctorState, ADiskThatFillsUpIsReported) {
  auto facts = good();
  facts.free_bytes = 100 << 20;
  expect(facts, "state.room", Severity::warning, "du -xhd1");
  facts.free_bytes = 1 << 20;
  expect(facts, "state.room", Severity::bad);
}

TEST(DoctorState, ReadStateCreatesNothing) {
  namespace fs = std::filesystem;
  const fs::path folder = own_folder("doctor_state");
  fs::remove_all(folder);
  ASSERT_TRUE(fs::create_directory(folder));
  const auto facts = read_state({folder / "deep" / "state"}, "");
  EXPECT_FALSE(facts.there);
  EXPECT_TRUE(facts.writable);
  EXPECT_GT(facts.free_bytes, 0U);
  EXPECT_TRUE(fs::is_empty(folder));
  std::ofstream(folder / "file") << "x";
  const auto file = read_state({folder / "file"}, "");
  EXPECT_TRUE(file.there);
  EXPECT_FALSE(file.is_folder);
  EXPECT_FALSE(read_state({folder / "file" / "state"}, "").writable);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace ovws::examine
