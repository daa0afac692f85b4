#include "daemon/examine/machine/configuration.hpp"

#include "tests/unit/doctor/expect.hpp"

namespace ovws::doctor {
namespace {

TEST(DoctorConfiguration, AnInvalidFileIsAFaultThatNamesTheKeyAndTheNearestOne) {
  ConfigurationFacts facts;
  facts.path = "/etc/ovws/ovwsd.json";
  facts.config = Config{};
  expect(facts, "configuration", Verdict::ok);
  facts.error = Error{Errc::invalid, "camera.exposure_su", "unknown key", {}, {}, "exposure_us"};
  expect(facts, "configuration", Verdict::fault,
         "in /etc/ovws/ovwsd.json: \"exposure_us\" in place of \"exposure_su\"");
  facts.error->nearest.clear();
  expect(facts, "configuration", Verdict::fault, "sudoedit /etc/ovws/ovwsd.json");
}

TEST(DoctorConfiguration, ThatSeesNoSpotsIsAFault) {
  ConfigurationFacts facts;
  facts.path = "a.json";
  facts.config = Config{};
  facts.unseen = Error{Errc::invalid, "camera.roi", "19 of 19 spots fall outside"};
  expect(facts, "configuration", Verdict::fault, "sudoedit a.json");
  EXPECT_NE(judge(facts)[0].meaning.find("camera.roi: 19 of 19 spots fall outside"),
            std::string::npos);
}

TEST(DoctorConfiguration, TheZerothOrderInTheRegionIsAWarning) {
  ConfigurationFacts facts;
  facts.path = "a.json";
  facts.config = Config{};
  expect(facts, "optics.zeroth_order", Verdict::ok);
  facts.zeroth_order = Error{Errc::invalid, "camera.roi", "the zeroth order falls at (3, 4) px"};
  expect(facts, "optics.zeroth_order", Verdict::warning, "sudoedit a.json");
  facts.error = Error{Errc::invalid, "optics", "nothing fits"};
  expect(facts, "optics.zeroth_order", Verdict::not_here);
}

TEST(DoctorConfiguration, NoFileIsAWarning) {
  ConfigurationFacts facts;
  facts.config = Config{};
  expect(facts, "configuration", Verdict::warning, "ovws doctor --config FILE");
}

TEST(DoctorConfiguration, ThatOfARunningDaemonIsJudgedAndNamed) {
  ConfigurationFacts facts;
  facts.zeroth_order = Error{Errc::invalid, "camera.roi", "of the file"};
  judge_instead(facts, Config{}, "tcp://127.0.0.1:7702", "");
  expect(facts, "configuration", Verdict::ok);
  expect(facts, "optics.zeroth_order", Verdict::ok);
  facts.path = "a.json";
  const std::string meaning = named(judge(facts), "configuration").meaning;
  EXPECT_NE(meaning.find("a.json is valid, and the checks judge the settings that the daemon at "
                         "tcp://127.0.0.1:7702 uses"),
            std::string::npos)
      << meaning;
  facts.error = Error{Errc::invalid, "camera.exposure_su", "unknown key"};
  expect(facts, "configuration", Verdict::fault, "sudoedit a.json");
  expect(facts, "optics.zeroth_order", Verdict::ok);
  judge_instead(facts, Config{}, "tcp://127.0.0.1:7702", "camera.roi: 3 spots fall outside");
  facts.error.reset();
  expect(facts, "configuration", Verdict::fault, "ovws setup spot");
  EXPECT_NE(named(judge(facts), "configuration").meaning.find("settings that the daemon uses"),
            std::string::npos);
}

TEST(DoctorConfiguration, SavedValuesAreNamedAndUnusedOnesAreAWarning) {
  ConfigurationFacts facts;
  facts.path = "a.json";
  facts.config = Config{};
  facts.saved = "saved values active: camera.gain_db (state/config.json)";
  expect(facts, "configuration", Verdict::ok);
  EXPECT_NE(judge(facts)[0].meaning.find(facts.saved), std::string::npos);
  facts.saved_is_unused = true;
  expect(facts, "configuration", Verdict::warning, "ovws call config.save");
}

TEST(DoctorConfiguration, RejectedSavedValuesAreAWarningUntilTheyAreRemoved) {
  ConfigurationFacts facts;
  facts.path = "a.json";
  facts.config = Config{};
  facts.rejected = "state/config.json.rejected";
  expect(facts, "configuration", Verdict::warning, "sudo rm state/config.json.rejected");
}

TEST(DoctorConfiguration, KeysThatTheDaemonCannotUseAreAFaultWithTheirOwnFix) {
  ConfigurationFacts facts;
  facts.path = "a.json";
  facts.config = Config{};
  facts.keys.error = Error{Errc::invalid, "security.secret_key", "cannot be read"};
  facts.keys.fix = "sudo chown ovws key.json";
  expect(facts, "configuration", Verdict::fault, "sudo chown ovws key.json");
  facts.keys = {Error{Errc::invalid, "control.endpoint", "others can reach it"}, "", true, ""};
  expect(facts, "configuration", Verdict::fault, "sudoedit a.json");
}

TEST(DoctorConfiguration, KeysThatThisUserMayNotReadAreNotJudged) {
  ConfigurationFacts facts;
  facts.path = "a.json";
  facts.config = Config{};
  facts.keys.read = false;
  facts.keys.user = "ovws";
  expect(facts, "configuration", Verdict::not_here, "sudo -u ovws ovws doctor --config a.json");
}

}  // namespace
}  // namespace ovws::doctor
