// Every error outside frames: file, line, key, and the nearest valid word.
#include <gtest/gtest.h>

#include "scene_test.h"

using namespace insitu::scene;
using test::error_of;
using test::error_of_text;

namespace {

std::string probe_error(const std::string& keys) {
  return error_of(test::probe(keys));
}
std::string tracer_error(const std::string& keys) {
  return error_of(test::tracer(keys));
}
std::string points_error(const std::string& value, const std::string& frame = "cartesian") {
  return error_of("probes: [{name: p, frame: " + frame + ", points: " + value + "}]");
}

#define EXPECT_HAS(message, part)                                                                  \
  do {                                                                                             \
    const std::string text_ = (message);                                                           \
    EXPECT_EQ(text_.rfind("s.yaml:", 0), 0u) << text_;                                             \
    EXPECT_NE(text_.find(part), std::string::npos) << text_;                                       \
  } while (false)

} // namespace

TEST(SceneErrors, Version) {
  EXPECT_EQ(error_of_text("output: o"), "s.yaml:1: key 'insitu' is missing in the scene");
  EXPECT_EQ(error_of_text("insitu: 2"),
            "s.yaml:1: insitu: version 2 of the scene format is not known to this library (1)");
  EXPECT_HAS(error_of_text("insitu: one"),
             "insitu: an integer from 1 to 2147483647 expected, 'one' found");
  EXPECT_HAS(error_of_text("insitu: '1'"), "the text '1' found");
  EXPECT_HAS(error_of_text("insitu:"), "expected, nothing found");
}

TEST(SceneErrors, Top) {
  EXPECT_EQ(
      error_of("framse: []"),
      "s.yaml:2: key 'framse' is unknown in the scene; did you mean "
      "'frames'? (keys: insitu, output, page, "
      "locator, seam_tolerance, checkpoint, record, hold, every, when, probes, tracers, frames)");
  EXPECT_HAS(error_of("output:"), "output: a text expected, nothing found");
  EXPECT_HAS(error_of("every: -1"), "every: an integer from 1 to 1000000000 expected, '-1' found");
  EXPECT_HAS(error_of("every: 1.5"), "'1.5' found");
  EXPECT_HAS(error_of("every: 99999999999999999999"), "'99999999999999999999' found");
  EXPECT_HAS(error_of("every: [1]"), "a list of 1 found");
  EXPECT_HAS(error_of("every: {a: 1}"), "a map found");
  EXPECT_EQ(error_of("seam_tolerance: 0.2"),
            "s.yaml:2: seam_tolerance: a number from 0 to 0.1 expected, '0.2' found");
  EXPECT_HAS(error_of("seam_tolerance: -1e-6"), "'-1e-6' found");
  EXPECT_HAS(error_of("seam_tolerance: nan"), "'nan' found");
  EXPECT_HAS(error_of("seam_tolerance: none"), "seam_tolerance: a number from 0 to 0.1");
  EXPECT_HAS(error_of("seams_tolerance: 0"), "did you mean 'seam_tolerance'?");
  EXPECT_HAS(error_of("frames: 3"), "frames: a list expected, '3' found");
  EXPECT_HAS(error_of("probes:"), "probes: a list expected, nothing found");
  EXPECT_HAS(error_of("tracers: [3]"), "tracers[0]: a map of name, mesh, seeds");
}

TEST(SceneErrors, Locator) {
  EXPECT_EQ(error_of("locator: {method: bhv}"),
            "s.yaml:2: locator.method: 'bhv' is not one of auto, bvh, user_geometry, "
            "replicated_faces, shared_faces, "
            "shared_bilinear_faces; did you mean 'bvh'?");
  EXPECT_HAS(error_of("locator: {builder: mortn}"),
             "locator.builder: 'mortn' is not one of auto, morton, "
             "surface_area; did you mean 'morton'?");
  EXPECT_HAS(error_of("locator: {biulder: auto}"), "did you mean 'builder'?");
  EXPECT_HAS(error_of("locator: bvh"),
             "locator: a map of method, backend, builder expected, 'bvh' found");
}

TEST(SceneErrors, When) {
  EXPECT_EQ(
      error_of("when: max(p) >"),
      "s.yaml:2: when: a value expected, end of the condition found (column 9 of the condition)\n"
      "    max(p) >\n"
      "            ^");
  EXPECT_HAS(probe_error("\n when: cylce > 1"),
             "s.yaml:3: probes[0].when: the name 'cylce' is unknown; did you mean "
             "'cycle'?");
  EXPECT_HAS(error_of("when: [1]"), "when: a text expected");
  EXPECT_HAS(error_of("when: !x"), "the tag");
}

TEST(SceneErrors, Names) {
  EXPECT_EQ(error_of("probes:\n- {points: [[0, 0, 0]]}"),
            "s.yaml:3: key 'name' is missing in probes[0]");
  for (const char* name :
       {"../up", ".hidden", "a/b", "'a:b'", "' a'", "'a '", "\"a\\nb\"", "'a\\b'"}) {
    EXPECT_HAS(error_of("probes: [{points: [[0, 0, 0]], name: " + std::string(name) + "}]"),
               "cannot name a file");
  }
  EXPECT_HAS(error_of("probes: [{points: [[0, 0, 0]], name: " + std::string(101, 'a') + "}]"),
             "cannot name a file");
  EXPECT_HAS(error_of("probes: [{points: [[0, 0, 0]], name: ''}]"),
             "probes[0].name: a text expected");
  EXPECT_EQ(
      error_of(test::probe("accuracy: fast") + "\nframes:\n- {name: p, volume: {field: r}}\n"),
      "s.yaml:4: frames[0].name: the name 'p' is already used in this scene");
}

TEST(SceneErrors, Probes) {
  EXPECT_EQ(error_of("probes:\n- name: a"), "s.yaml:3: key 'points' is missing in probes[0]");
  EXPECT_EQ(probe_error("feilds: [a]"), "s.yaml:2: key 'feilds' is unknown in probes[0]; did you "
                                        "mean 'fields'? (keys: name, mesh, points, frame, "
                                        "fields, attached, accuracy, outside, greatest_distance, "
                                        "output, every, when)");
  EXPECT_HAS(probe_error("fields: pressure"),
             "probes[0].fields: a list expected, 'pressure' found");
  EXPECT_HAS(probe_error("fields: [[a]]"), "probes[0].fields[0]: a text expected");
  EXPECT_HAS(probe_error("fields: [a, b, a]"), "probes[0].fields[2]: 'a' is given twice");
  EXPECT_HAS(probe_error("mesh: [a]"), "probes[0].mesh: a text expected");
  EXPECT_HAS(probe_error("accuracy: exakt"), "did you mean 'exact'?");
  EXPECT_HAS(probe_error("output: [cvs]"),
             "probes[0].output[0]: 'cvs' is not one of csv, vtp, json, netcdf; did you mean "
             "'csv'?");
  EXPECT_HAS(probe_error("output: csv"), "probes[0].output: a list expected");
  EXPECT_HAS(probe_error("output: []"), "at least one format expected");
  EXPECT_HAS(probe_error("output: [csv, csv]"), "probes[0].output[1]: 'csv' is given twice");
  EXPECT_HAS(probe_error("every: 0"), "probes[0].every: an integer from 1");
}

TEST(SceneErrors, NearestCells) {
  EXPECT_HAS(test::error_of(test::probe("outside: near")), "nearest");
  EXPECT_HAS(test::error_of(test::probe("outside: nearest, greatest_distance: 0")),
             "greatest_distance");
  EXPECT_HAS(test::error_of(test::probe("greatest_distance: 3")), "'outside: nearest' asks for it");
}

TEST(SceneErrors, Points) {
  EXPECT_HAS(points_error("[]"), "probes[0].points: at least one point expected");
  EXPECT_HAS(points_error("[1, 2, 3]"),
             "probes[0].points[0]: a list of 3 numbers expected, '1' found");
  EXPECT_HAS(points_error("[[1, 2]]"), "a list of 3 numbers expected, a list of 2 found");
  EXPECT_HAS(points_error("[[0, 0, 0],\n[1, nan, 3]]"),
             "s.yaml:3: probes[0].points[1][1]: a finite number expected, 'nan' found");
  EXPECT_HAS(points_error("[[1, 1e999, 3]]"), "'1e999' found");
  EXPECT_HAS(points_error("[[1, 1d0, 3]]"), "'1d0' found");
  EXPECT_HAS(points_error("~"), "a file's name, a list of points, or a map");
  EXPECT_HAS(points_error("{}"), "exactly one of");
  EXPECT_HAS(points_error("{line: {}, grid: {}}"), "2 keys found");
  EXPECT_HAS(points_error("{lien: {}}"),
             "key 'lien' is unknown in probes[0].points; did you mean 'line'?");
  EXPECT_HAS(points_error("{points: {points: a}}"),
             "a list of points or a file's name expected, a map found");
  EXPECT_HAS(points_error("{line: {}}"),
             "key 'from' is missing in probes[0].points.line\n"
             "s.yaml:2: key 'to' is missing in probes[0].points.line\n"
             "s.yaml:2: key 'count' is missing in probes[0].points.line");
  EXPECT_HAS(points_error("{line: {from: [0, 0, 0], to: [1, 1, 1], count: 0}}"),
             "an integer from 1 to 1000000000");
  EXPECT_HAS(points_error("{line: {from: [0, 0, 0], to: [1, 1, 1], count: 1000000001}}"),
             "points.line.count");
  EXPECT_HAS(points_error("{grid: {min: [0, 0, 0], max: [1, 1, 1], counts: [100000, 100000, 1]}}"),
             "the counts make more than 1000000000 points");
  EXPECT_HAS(
      points_error(
          "{grid: {min: [0, 0, 0], max: [1, 1, 1], counts: [1000000000, 1000000000, 1000000000]}}"),
      "the counts make more than 1000000000 points");
  EXPECT_HAS(points_error("{grid: {min: [0, 0, 0], max: [1, 1, 1], counts: [2, 2]}}"),
             "a list of 3 integers expected, a list of 2 found");
  EXPECT_HAS(points_error("{box: {min: [0, 2, 0], max: [1, 1, 1], counts: [2, 2, 2]}}"),
             "'min' lies above 'max'");
  EXPECT_HAS(points_error("{plane: {origin: [0, 0, 0], u: [1, 0, 0], v: [0, 1, 0], counts: [2]}}"),
             "a list of 2 integers");
  EXPECT_HAS(points_error("{sphere: {center: [0, 0, 0], radius: 0, count: 1}}"),
             "a number above 0 expected");
  EXPECT_NO_THROW(test::parse("probes: [{name: p, points: {grid: {min: [0, 0, 0], max: [1, 1, 1], "
                              "counts: [1000, 1000, 1000]}}}]"));
}

TEST(SceneErrors, Curtains) {
  const auto curtain = [](const std::string& through, const std::string& levels,
                          const std::string& frame = "cartesian", const std::string& count = "2") {
    return points_error("{curtain: {through: " + through + ", count: " + count +
                            ", levels: " + levels + "}}",
                        frame);
  };
  EXPECT_HAS(points_error("{curtain: {}}"),
             "key 'through' is missing in probes[0].points.curtain\n"
             "s.yaml:2: key 'count' is missing in probes[0].points.curtain\n"
             "s.yaml:2: key 'levels' is missing in probes[0].points.curtain");
  EXPECT_HAS(curtain("[[0, 0]]", "[0]"), "curtain.through: at least two places expected");
  EXPECT_HAS(curtain("[[0, 0], [1, 2, 3]]", "[0]"), "a list of 2 numbers expected");
  EXPECT_HAS(curtain("[[0, 0], [1, 2], [1, 2]]", "[0]"),
             "curtain.through[2]: the place before is the same");
  EXPECT_HAS(curtain("[[0, 0], [1, 1]]", "[0, 1, 1]"),
             "curtain.levels: levels ascend or descend; level 2 does not");
  EXPECT_HAS(curtain("[[0, 0], [1, 1]]", "[3, 2, 4]"), "level 2 does not");
  EXPECT_HAS(curtain("[[0, 0], [1, 1]]", "{from: 1, to: 1, count: 2}"), "level 1 does not");
  EXPECT_HAS(curtain("[[0, 0], [1, 1]]", "[]"), "a list of");
  EXPECT_HAS(curtain("[[0, 0], [1, 1]]", "7"),
             "a list of numbers, or a map of from, to and count expected");
  EXPECT_HAS(curtain("[[0, 0], [1, 1]]", "[0]", "cartesian", "1"), "an integer from 2");
  EXPECT_HAS(curtain("[[0, 0], [1, 1]]", "[0, 1]", "cartesian", "600000000"),
             "the stations and levels make more than 1000000000 points");
  EXPECT_HAS(curtain("[[0, 0], [1, 1]]", "[0]", "geocentric"), "no upright in geocentric");
  EXPECT_HAS(
      test::error_of("probes: [{name: p, attached: body, points: {curtain: {through: [[0, 0], "
                     "[1, 1]], count: 2, levels: [0]}}}]"),
      "probes[0].attached: a curtain stands where it is");
}

TEST(SceneErrors, Latitudes) {
  EXPECT_HAS(points_error("[[0, 0, 0], [10, 91, 0]]", "geodetic"), "point 1 has the latitude 91.0");
  EXPECT_HAS(points_error("{line: {from: [0, 0, 0], to: [0, -95, 0], count: 2}}", "geodetic"),
             "'to' has the latitude");
  EXPECT_HAS(points_error("{transect: {from: [0, 95, 0], to: [0, 0, 0], count: 2}}", "geodetic"),
             "'from' has");
  EXPECT_HAS(
      points_error("{box: {min: [0, 0, 0], max: [1, 95, 1], counts: [2, 2, 2]}}", "geodetic"),
      "'max' has");
  EXPECT_HAS(
      points_error("{plane: {origin: [0, 80, 0], u: [1, 0, 0], v: [0, 20, 0], counts: [2, 2]}}",
                   "geodetic"),
      "'origin' + 'v' has the latitude 100");
  EXPECT_HAS(points_error("{sphere: {center: [0, 0, 0], radius: 1, count: 1}}", "geodetic"),
             "a sphere has no meaning");
  EXPECT_HAS(
      points_error("{curtain: {through: [[0, 0], [1, 91]], count: 2, levels: [0]}}", "geodetic"),
      "place 1 has the latitude 91");
  EXPECT_NO_THROW(test::parse("probes: [{name: p, points: [[0, 91, 0]]}]"));
}

TEST(SceneErrors, FramesOfReference) {
  EXPECT_EQ(probe_error("frame: geodetc"),
            "s.yaml:2: probes[0].frame: 'geodetc' is not one of mesh, cartesian, "
            "geocentric, geodetic; did you mean 'geodetic'?");
  EXPECT_HAS(probe_error("frame: [1]"), "mesh, cartesian, geocentric, geodetic, {geodetic: depth}");
  EXPECT_HAS(probe_error("frame: {}"), "exactly one of enu, utm, geodetic");
  EXPECT_HAS(probe_error("frame: {enu: [0, 0, 0], utm: 33N}"), "2 keys found");
  EXPECT_HAS(probe_error("frame: {enu: [0, 0]}"), "probes[0].frame.enu: a list of 3 numbers");
  EXPECT_HAS(probe_error("frame: {enu: [0, 91, 0]}"), "a latitude from -90 to 90");
  for (const char* zone : {"0N", "61N", "33", "33U", "N", "-3N", "133N", "''"}) {
    EXPECT_HAS(probe_error("frame: {utm: " + std::string(zone) + "}"), "a UTM zone from 1 to 60");
  }
  EXPECT_HAS(probe_error("frame: {geodetic: deep}"), "'deep' is not one of height, depth");
}

TEST(SceneErrors, Tracers) {
  EXPECT_EQ(error_of("tracers: [{name: t}]"), "s.yaml:2: key 'seeds' is missing in tracers[0]\n"
                                              "s.yaml:2: key 'velocity' is missing in tracers[0]");
  EXPECT_HAS(tracer_error("kind: pathlines"),
             "'pathlines' is not one of streamline, pathline, streakline; did you "
             "mean 'pathline'?");
  EXPECT_HAS(tracer_error("velocty: u"), "did you mean 'velocity'?");
  EXPECT_HAS(tracer_error("release: twice"), "tracers[0].release: 'twice' is not one of once");
  EXPECT_HAS(tracer_error("release: {until: 3}"), "either 'every' (cycles) or 'interval' (time)");
  EXPECT_HAS(tracer_error("release: {every: 1, interval: 2}"), "either 'every'");
  EXPECT_HAS(tracer_error("release: {every: 0}"), "tracers[0].release.every: an integer from 1");
  EXPECT_HAS(tracer_error("release: {interval: 0}"), "tracers[0].release.interval: a number");
  EXPECT_HAS(tracer_error("release: {when: max(p}"), "tracers[0].release.when: ");
  EXPECT_HAS(tracer_error("geodesics: [length]"), "'length' is not one of path_length");
  EXPECT_HAS(tracer_error("geodesics: [path_length, path_length]"), "given twice");
  EXPECT_HAS(tracer_error("kind: streamline, geodesics: [path_length]"),
             "tracers[0].geodesics: streamlines are of one time");
  EXPECT_HAS(tracer_error("kind: streamline, release: once"), "belongs to path- and streaklines");
  EXPECT_HAS(tracer_error("kind: streamline, output: [netcdf]"), "netcdf is for path- and");
  EXPECT_HAS(test::error_of("insitu: 1\nprobes: [{name: gauges, points: [[0, 0, 0]]}]\n"
                            "tracers: [{name: t, velocity: u, seeds: {probe: gauge}}]"),
             "tracers[0].seeds.probe: the scene has no probe 'gauge'; did you mean 'gauges'?");
  EXPECT_HAS(test::error_of("insitu: 1\nprobes: [{name: p, points: [[0, 0, 0]]}]\ntracers: "
                            "[{name: t, velocity: u, frame: geodetic, seeds: {probe: p}}]"),
             "the frame of these seeds is the probe's");
  EXPECT_HAS(tracer_error("output: [json]"), "'json' is not one of csv, vtp");
  EXPECT_HAS(tracer_error("until: {duration: 0}"),
             "tracers[0].until.duration: a number above 0 expected");
  EXPECT_HAS(tracer_error("until: {length: -1}"), "tracers[0].until.length");
  EXPECT_HAS(tracer_error("until: {lenght: 1}"), "did you mean 'length'?");
  EXPECT_HAS(error_of("tracers: [{name: t, velocity: u, seeds: [[0]]}]"),
             "tracers[0].seeds[0]: a list of 3 numbers");
}

TEST(SceneErrors, Integrator) {
  EXPECT_HAS(tracer_error("integrator: {method: rk5}"),
             "'rk5' is not one of euler, rk4, bs32, dopri5; did you mean 'rk4'?");
  EXPECT_HAS(tracer_error("integrator: {tolerence: 1}"), "did you mean 'tolerance'?");
  for (const char* key : {"step", "tolerance", "min_step", "max_step"}) {
    EXPECT_HAS(tracer_error("integrator: {" + std::string(key) + ": 0}"),
               "tracers[0].integrator." + std::string(key) +
                   ": a number above 0 expected, '0' found");
  }
  EXPECT_HAS(tracer_error("integrator: {max_steps: 0}"), "an integer from 1 to 1000000000");
  EXPECT_HAS(tracer_error("integrator: {min_step: 2, max_step: 1}"),
             "'min_step' is larger than 'max_step'");
  EXPECT_HAS(tracer_error("integrator: {step: 3, max_step: 2}"), "'step' does not lie between");
  EXPECT_HAS(tracer_error("integrator: {step: 1, min_step: 2}"), "'step' does not lie between");
  for (const char* key : {"tolerance", "min_step", "max_step"}) {
    EXPECT_HAS(tracer_error("integrator: {method: rk4, " + std::string(key) + ": 1}"),
               "tracers[0].integrator." + std::string(key) + ": rk4 has fixed steps");
    EXPECT_HAS(tracer_error("integrator: {method: euler, " + std::string(key) + ": 1}"),
               "tracers[0].integrator." + std::string(key) + ": euler has fixed steps");
  }
  EXPECT_HAS(tracer_error("integrator: {at_min_step: end}"),
             "tracers[0].integrator.at_min_step: it says what becomes of particles at 'min_step', "
             "which is missing");
  EXPECT_HAS(tracer_error("integrator: {min_step: 1, at_min_step: stop}"),
             "'stop' is not one of end, take");
  EXPECT_HAS(tracer_error("integrator: {method: rk4, at_min_step: take}"),
             "tracers[0].integrator.at_min_step: rk4 has fixed steps");
  EXPECT_HAS(tracer_error("integrator: {face_aware: 3}"), "tracers[0].integrator.face_aware");
  EXPECT_HAS(tracer_error("kind: streamline, direction: up"),
             "'up' is not one of forward, backward, both");
  EXPECT_HAS(tracer_error("direction: both"), "path- and streaklines follow the run");
  EXPECT_HAS(tracer_error("direction: backward, effects: [{diffusion: {coefficient: 1}}]"),
             "a random walk has no way back");
  EXPECT_HAS(tracer_error("direction: backward, effects: [{inertia: {response_time: 1}}]"),
             "drag makes every error grow");
  EXPECT_HAS(tracer_error("times: [0, 1, 1]"), "tracers[0].times: times must ascend");
  EXPECT_HAS(tracer_error("spacing: {time: 1}"), "this key belongs to streamlines");
  EXPECT_HAS(tracer_error("kind: streamline, spacing: {}"), "either 'length' or 'time' expected");
  EXPECT_HAS(tracer_error("kind: streamline, spacing: {length: 0}"), "tracers[0].spacing.length");
  EXPECT_HAS(tracer_error("times: 3"), "a list of times, or a map of interval, from and until");
  EXPECT_HAS(tracer_error("times: {from: 1}"), "key 'interval' is missing");
  EXPECT_HAS(tracer_error("times: {interval: 0}"), "tracers[0].times.interval");
  EXPECT_HAS(tracer_error("times: [1], every: 3"), "'times' says when the particles are written");
  EXPECT_HAS(tracer_error("kind: streamline, times: [1]"), "streamlines are of one moment");
  EXPECT_HAS(tracer_error("time_interpolation: square"),
             "'square' is not one of linear, quadratic, cubic");
  EXPECT_HAS(tracer_error("kind: streamline, time_interpolation: cubic"),
             "tracers[0].time_interpolation: streamlines see one step alone");
}

TEST(SceneErrors, TracerEffects) {
  const auto effect = [](const std::string& text) {
    return tracer_error("\n effects: [" + text + "]");
  };
  EXPECT_HAS(effect("diffusion"), "effect 'diffusion' needs options");
  EXPECT_HAS(effect("{diffusion: {}}"),
             "s.yaml:3: tracers[0].effects[0].diffusion: one of 'coefficient', 'horizontal'");
  EXPECT_HAS(effect("{diffusion: {coefficient: -1}}"), "'-1' found");
  EXPECT_HAS(effect("{diffusion: {coefficient: 1, vertical: 1}}"), "either 'coefficient' or");
  EXPECT_HAS(effect("{settling: {}}"), "exactly one of 'velocity', 'speed' expected");
  EXPECT_HAS(effect("{settling: {velocity: [0, 0, 1], speed: 1}}"), "exactly one of");
  EXPECT_HAS(effect("{settling: {speed: 1, down: [0, 0, 0]}}"), "a direction expected");
  EXPECT_HAS(effect("{windage: {factor: 0.1}}"), "key 'field' is missing");
  EXPECT_HAS(effect("{inertia: {diameter: 1}}"), "needs 'density' and 'viscosity'");
  EXPECT_HAS(effect("{inertia: {added_mass: true}}"), "'added_mass' needs 'density'");
  EXPECT_HAS(effect("{inertia: {response_time: 1, diameter: 1, density: 1, viscosity: 1}}"),
             "either 'response_time' or 'diameter'");
  EXPECT_HAS(effect("{coriolis: {rotation: [0, 0, 1]}}"), "add 'inertia'");
  EXPECT_HAS(effect("{boundary: bounce}"),
             "'bounce' is not one of leave, stop, slide, reflect, put_back");
  EXPECT_HAS(effect("{boundary: {restitution: 0.5}}"), "belongs to 'other: reflect'");
  EXPECT_HAS(effect("{boundary: {other: put_back, restitution: 0.5}}"), "'other: reflect'");
  EXPECT_HAS(effect("{boundary: {periodic: [w]}}"), "'w' is not one of x, y, z");
  EXPECT_HAS(effect("{age_limit: 0}"), "a number above 0 expected");
  EXPECT_HAS(effect("{remove: {when: 'max(salt) > 1'}}"), "a field is its value there");
  EXPECT_HAS(effect("{remove: {when: salt}}"), "a condition expected, a number found");
  EXPECT_HAS(effect("{age_limit: 1}, {age_limit: 2}"), "effect 'age_limit' is given twice");
  EXPECT_HAS(tracer_error("attached: body"), "'attached: body' moves particles with the mesh's");
  for (const char* moving :
       {"diffusion: {coefficient: 1}", "settling: {speed: 1}", "windage: {field: u}",
        "inertia: {response_time: 1}", "boundary: slide"}) {
    const std::string text = moving;
    EXPECT_HAS(test::error_of("insitu: 1\ntracers: [{name: t, attached: body, seeds: [[0, 0, 0]], "
                              "effects: [{age_limit: 3}, {" +
                              text + "}]}]"),
               "tracers[0].effects: 'attached: body' moves particles with the mesh's material; '" +
                   text.substr(0, text.find(':')) + "' moves them otherwise");
  }
  EXPECT_HAS(tracer_error("attached: bodies"), "'bodies' is not one of lab, body");
  const auto on_lines = [](const std::string& text) {
    return tracer_error("kind: streamline, effects: [" + text);
  };
  EXPECT_HAS(on_lines("{diffusion: {coefficient: 1}}]"), "a random walk has no velocity");
  EXPECT_HAS(on_lines("{boundary: put_back}]"), "'put_back' would begin a streamline again");
  EXPECT_HAS(on_lines("{boundary: {periodic: [x], other: reflect}}]"), "without 'inertia'");
  EXPECT_HAS(on_lines("{inertia: {response_time: 1}}]"), "needs 'until: {duration}' or");
  EXPECT_HAS(on_lines("{inertia: {response_time: 1}}, {age_limit: 1}], direction: both"),
             "'inertia' on streamlines needs 'direction: forward'");
  EXPECT_HAS(tracer_error("geodesics: [release_distance, path_length], effects: [{boundary: "
                          "{periodic: [x]}}]"),
             "tracers[0].geodesics: 'path_length' adds up the ways from cycle to cycle");
  EXPECT_HAS(tracer_error("effects: [difusion]"),
             "effect 'difusion' is unknown; did you mean 'diffusion'?");
}
