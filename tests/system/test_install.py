"""`cmake --install` installs complete and correct files."""
import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

from case import PROGRAM_PATIENCE_S, ROOT

UNIT = "usr/lib/systemd/system/{}.service"
FILES = ("usr/bin/ovwsd", "usr/bin/ovws", "usr/bin/ovws-twin", "usr/bin/ovws-web", "usr/lib/ovws/ovws-image-codecs.so", "etc/ovws/ovwsd.json",
         UNIT.format("ovwsd"), UNIT.format("ovws-web"), UNIT.format("ovws-metrics"), "usr/share/doc/ovws/config/grafana/ovws.json",
         "usr/share/doc/ovws/config/cluster/Snakefile",
         "usr/share/man/man1/ovws.1", "usr/share/man/man1/ovws-twin.1", "usr/share/man/man8/ovwsd.8", "usr/share/man/man5/ovwsd.json.5",
         "usr/share/bash-completion/completions/ovws", "usr/lib/sysusers.d/ovws.conf",
         "usr/lib/tmpfiles.d/ovws.conf", "usr/lib/udev/rules.d/70-ovws-camera.rules", "usr/share/doc/ovws/README.md",
         "usr/share/ovws/schema/stream.wavefront.json", "usr/share/ovws/python/ovws_client/__init__.py",
         "usr/share/ovws/python/ovws_client/py.typed", "usr/share/ovws/python/ovws_bridges/fields.py", "usr/share/ovws/python/ovws_client-0.1.0-py3-none-any.whl")
GUIDES = tuple(str(path.relative_to(ROOT)) for path in sorted((ROOT / "daemon/guide").glob("*.md")))
DOCUMENTS = ("README.md", "proto/RECORDING.md", "proto/WIRE.md", "proto/python/README.md", "config/README.md", "drivers/twin/README.md", *GUIDES)


def run(*command, **more):
    return subprocess.run([str(part) for part in command], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S, **more)


class Install(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.root = pathlib.Path(cls.folder.name)
        done = run("cmake", "--install", os.environ["OVWS_BUILD"], "--prefix", "/usr", env=os.environ | {"DESTDIR": str(cls.root)})
        assert done.returncode == 0, done.stderr

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_everything_is_there(self):
        for name in FILES:
            self.assertTrue((self.root / name).is_file(), name)
        self.assertTrue(os.access(self.root / "usr/share/doc/ovws/config/cluster/profiles/slurm/status", os.X_OK))

    def test_the_installed_daemon_accepts_the_installed_configuration(self):
        done = run(self.root / "usr/bin/ovwsd", "--check-config", "--config", self.root / "etc/ovws/ovwsd.json")
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_programs_are_hardened(self):
        for name in ("ovwsd", "ovws", "ovws-web", "ovws-twin"):
            with self.subTest(program=name):
                said = run("readelf", "--wide", "--file-header", "--program-headers", "--dynamic", "--dyn-syms", self.root / "usr/bin" / name).stdout
                self.assertRegex(said, r"Type:\s+DYN \(Position-Independent Executable")
                self.assertRegex(said, r"GNU_RELRO")
                self.assertRegex(said, r"FLAGS.*BIND_NOW|FLAGS_1.*NOW")
                self.assertRegex(said, r"__stack_chk_fail")
                self.assertRegex(said, r"__\w+_chk@GLIBC")

    def test_a_program_starts_without_the_libraries_of_image_formats(self):
        for name in ("ovwsd", "ovws", "ovws-web", "ovws-twin"):
            libraries = re.findall(r"^\s*(lib\S+)", run("ldd", self.root / "usr/bin" / name).stdout, re.M)
            print(f"\n  {name}: {len(libraries)} shared libraries")
            kept_out = r"lib(opencv|gdal|tiff|jpeg)" if name == "ovwsd" else r"lib(opencv_imgcodecs|gdal|tiff|jpeg)"
            self.assertEqual([library for library in libraries if re.match(kept_out, library)], [])

    def test_the_installed_command_finds_its_image_formats(self):
        image = self.root / "hologram.tiff"
        done = run(self.root / "usr/bin/ovws", "hologram", "-o", image)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(image.read_bytes()[:2], b"II")
        codecs = self.root / "usr/lib/ovws/ovws-image-codecs.so"
        hidden = codecs.rename(codecs.with_suffix(".hidden"))
        self.addCleanup(hidden.rename, codecs)
        done = run(self.root / "usr/bin/ovws", "hologram", "-o", self.root / "other.png")
        self.assertEqual(done.returncode, 1)
        self.assertIn("ovws-image-codecs.so", done.stderr)
        self.assertFalse((self.root / "other.png").exists())
        done = run(self.root / "usr/bin/ovws", "measure", "--model-reference", image, image)
        self.assertEqual((done.returncode, done.stderr.count("ovws-image-codecs.so")), (1, 2), done.stderr)

    def test_the_documents_links_resolve(self):
        self.assertGreater(len(GUIDES), 10)
        for name in DOCUMENTS:
            document = self.root / "usr/share/doc/ovws" / name
            for link in re.findall(r"\]\(([^)#:]+)[^):]*\)", document.read_text()):
                with self.subTest(document=name, link=link):
                    self.assertTrue((document.parent / link).exists())

    def test_the_package_is_whole(self):
        """Whether it installs on a clean Debian is tested by tests/package."""
        built = run("cpack", "--config", pathlib.Path(os.environ["OVWS_BUILD"]) / "CPackConfig.cmake", "-B", self.root / "package")
        self.assertEqual(built.returncode, 0, built.stdout + built.stderr)
        (package,) = (self.root / "package").glob("ovws_*.deb")
        needs = run("dpkg-deb", "-f", package, "Depends").stdout
        for library in ("libaravis-0.8-0", "libsdl2-2.0-0", "libzmq5", "libhdf5-103-1", "systemd", "procps"):
            self.assertIn(library, needs)
        held = {line.split(maxsplit=5)[5].removeprefix("./") for line in run("dpkg-deb", "-c", package).stdout.splitlines()}
        self.assertEqual(set(FILES) - held, set())
        scripts = self.root / "control"
        self.assertEqual(run("dpkg-deb", "-e", package, scripts).returncode, 0)
        self.assertEqual((scripts / "conffiles").read_text(), "/etc/ovws/ovwsd.json\n")
        for name in ("postinst", "prerm", "postrm"):
            self.assertEqual(run("sh", "-n", scripts / name).returncode, 0, name)
            self.assertTrue((scripts / name).stat().st_mode & 0o111, name)

    def check_unit(self, name, most_exposure):
        # systemd-analyze verify exits 0 even on unknown keys, so check its output.
        unit = self.root / f"{name}.service"
        unit.write_text((self.root / UNIT.format(name)).read_text().replace(f"/usr/bin/{name}", str(self.root / "usr/bin" / name)))
        done = run("systemd-analyze", "verify", "--man=no", unit)
        self.assertEqual(done.stderr.strip(), "")
        exposure = run("systemd-analyze", "security", "--offline=yes", unit).stdout.strip().splitlines()[-1]
        print("\n ", exposure)
        self.assertLessEqual(float(exposure.split(":")[1].split()[0]), most_exposure)
        # Remaining findings, whose reasons are in the unit.
        points = json.loads(run("systemd-analyze", "security", "--offline=yes", "--json=short", unit).stdout)
        reasons = re.findall(r"[@\w]+", " ".join(re.findall(r"^#   ([^:]+):", unit.read_text(), re.M)))
        left = [point["name"] for point in points if float(point["exposure"] or 0) > 0.0]
        self.assertGreater(len(left), 2)
        for point in left:
            self.assertTrue(set(re.findall(r"[@\w]+", point)) & set(reasons), f"{point} has no reason in the unit")

    def test_the_daemons_unit_is_right(self):
        self.check_unit("ovwsd", 2.5)

    def test_the_pages_unit_is_right(self):
        self.check_unit("ovws-web", 1.0)

    def test_the_unit_of_the_metrics_is_right(self):
        unit = self.root / "ovws-metrics.service"
        unit.write_text((self.root / UNIT.format("ovws-metrics")).read_text().replace("/usr/bin/ovws", str(self.root / "usr/bin/ovws")))
        self.assertEqual(run("systemd-analyze", "verify", "--man=no", unit).stderr.strip(), "")
        exposure = run("systemd-analyze", "security", "--offline=yes", unit).stdout.strip().splitlines()[-1]
        print("\n ", exposure)
        self.assertLessEqual(float(exposure.split(":")[1].split()[0]), 1.5)

    def test_users_and_folders_are_declared_as_systemd_reads_them(self):
        done = run("systemd-sysusers", "--dry-run", self.root / "usr/lib/sysusers.d/ovws.conf")
        self.assertIn("ovws-data", done.stdout + done.stderr)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_nothing_but_the_daemon_runs_as_its_user_or_is_in_its_group(self):
        for name in ("ovws-web", "ovws-metrics"):
            unit = (self.root / UNIT.format(name)).read_text()
            self.assertIn("\nDynamicUser=yes\n", unit)
            self.assertIn(f"\nLoadCredential=ovws.key:{name}.key\n", unit)
            # The page may read recordings, as the members of this group may.
            allowed = "SupplementaryGroups=ovws-data\n" if name == "ovws-web" else ""
            self.assertEqual("".join(re.findall(r"(?m)^(?:User|Group|SupplementaryGroups)=.*\n", unit)), allowed)
            # Options of the service come only from the unit, never from the daemon's configuration.
            self.assertNotRegex(unit, r"(?m)^EnvironmentFile=.*/etc/ovws")

    def test_who_reads_recordings_can_write_nothing(self):
        with tempfile.TemporaryDirectory() as name:
            root = pathlib.Path(name)
            for folder in ("etc", "var/lib"):
                (root / folder).mkdir(parents=True)
            # As left by an earlier version, whose daemon wrote its configuration.
            configuration = root / "etc/ovws/ovwsd.json"
            configuration.parent.mkdir(mode=0o775)
            configuration.write_text("{}")
            os.chown(configuration, 990, 990)
            for program, file in (("systemd-sysusers", "sysusers"), ("systemd-tmpfiles --create", "tmpfiles")):
                done = run(*program.split(), f"--root={root}", self.root / f"usr/lib/{file}.d/ovws.conf")
                self.assertEqual(done.returncode, 0, done.stderr)
            groups = {line.split(":")[0]: line.split(":")[2:] for line in (root / "etc/group").read_text().splitlines()}
            self.assertEqual({group[1] for group in groups.values()}, {""}, "nobody is a member by itself")
            folders = {folder: (root / folder).stat() for folder in ("etc/ovws", "etc/ovws/ovwsd.json", "var/lib/ovws", "var/lib/ovws/recordings")}
            shown = {folder: (f"{about.st_mode & 0o7777:o}", about.st_gid) for folder, about in folders.items()}
            daemon, data = int(groups["ovws"][0]), int(groups["ovws-data"][0])
            self.assertEqual(shown, {"etc/ovws": ("755", 0), "etc/ovws/ovwsd.json": ("644", 0), "var/lib/ovws": ("755", daemon), "var/lib/ovws/recordings": ("2750", data)})


if __name__ == "__main__":
    unittest.main(verbosity=2)
