// Every key outside frames: its value read, and its default where it is absent.
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

#include "scene_test.h"

using namespace insitu;
using namespace insitu::scene;
using test::parse;

TEST(SceneKeys, EmptySceneHasDefaults) {
  const SceneDescription scene = parse("");
  EXPECT_EQ(scene.file, "s.yaml");
  EXPECT_EQ(scene.output, "out");
  EXPECT_TRUE(scene.page);
  EXPECT_EQ(scene.locator.choice, query::LocatorChoice());
  EXPECT_EQ(scene.locator.builder, accel::Builder::automatic);
  EXPECT_EQ(scene.trigger.every, 1);
  EXPECT_FALSE(scene.trigger.when);
  EXPECT_TRUE(scene.probes.empty() && scene.tracers.empty() && scene.frames.empty());
}

TEST(SceneKeys, Top) {
  const SceneDescription scene =
      parse("output: results/run 7\npage: false\nevery: 10\nwhen: max(p) > 2\n");
  EXPECT_EQ(scene.output, "results/run 7");
  EXPECT_FALSE(scene.page);
  EXPECT_EQ(scene.trigger.every, 10);
  ASSERT_TRUE(scene.trigger.when);
  EXPECT_EQ(scene.trigger.when->text(), "max(p) > 2");
  EXPECT_EQ(scene.trigger.line, 5);
}

TEST(SceneKeys, LocatorMethodsBackendsAndBuilders) {
  for (int m = 0; m < accel::method_count; ++m) {
    const auto method = accel::Method(m);
    const auto scene = parse("locator: {method: " + std::string(name(method)) + "}");
    EXPECT_EQ(scene.locator.choice, (query::LocatorChoice{method, {}}));
    EXPECT_EQ(scene.locator.line, 2);
  }
  for (int b = 0; b < accel::backend_count; ++b) {
    const auto backend = accel::Backend(b);
    EXPECT_EQ(parse("locator: {backend: " + std::string(name(backend)) + "}").locator.choice,
              (query::LocatorChoice{{}, backend}));
  }
  EXPECT_EQ(parse("locator: {method: auto, backend: auto}").locator.choice, query::LocatorChoice());
  using accel::Builder;
  for (const auto& [word, builder] : {std::pair{"auto", Builder::automatic},
                                      {"morton", Builder::morton},
                                      {"surface_area", Builder::surface_area}})
    EXPECT_EQ(parse("locator: {builder: " + std::string(word) + "}").locator.builder, builder);
}

TEST(SceneKeys, ItemsInheritTheTriggerOrHaveTheirOwn) {
  const auto scene =
      parse("every: 10\nwhen: time > 1\n"
            "probes: [{name: a, points: [[0, 0, 0]]}, {name: b, points: [[0, 0, 0]], every: 2}]\n"
            "tracers: [{name: c, seeds: [[0, 0, 0]], velocity: u, when: cycle > 3}]\n"
            "frames: [{name: d, volume: {field: r}, every: 5, when: time < 9}]\n");
  EXPECT_EQ(scene.probes[0].trigger.every, 10);
  EXPECT_EQ(scene.probes[0].trigger.when->text(), "time > 1");
  EXPECT_EQ(scene.probes[1].trigger.every, 2);
  EXPECT_FALSE(scene.probes[1].trigger.when);
  EXPECT_EQ(scene.tracers[0].trigger.every, 1);
  EXPECT_EQ(scene.tracers[0].trigger.when->text(), "cycle > 3");
  EXPECT_EQ(scene.frames[0].trigger.every, 5);
  EXPECT_EQ(scene.frames[0].trigger.when->text(), "time < 9");
}

TEST(SceneKeys, ProbeDefaults) {
  const Probe probe = parse("probes:\n- name: gauges\n  points: gauges.csv\n").probes[0];
  EXPECT_EQ(probe.name, "gauges");
  EXPECT_TRUE(probe.mesh.empty());
  EXPECT_EQ(std::get<PointFile>(probe.points).path, "/base/gauges.csv");
  EXPECT_EQ(probe.points_line, 4);
  EXPECT_EQ(probe.line, 3);
  EXPECT_EQ(probe.frame.kind, FrameOfReference::Kind::mesh);
  EXPECT_TRUE(probe.fields.empty());
  EXPECT_EQ(probe.accuracy, INSITU_EXACT);
  EXPECT_EQ(probe.output, std::vector<TableFormat>{TableFormat::csv});
}

TEST(SceneKeys, ProbeKeys) {
  const Probe probe =
      parse(test::probe("mesh: ocean,\n fields: [p, u], accuracy: fast, output: [vtp, csv, json]"))
          .probes[0];
  EXPECT_EQ(probe.mesh.text, "ocean");
  EXPECT_EQ(probe.mesh.line, 2);
  ASSERT_EQ(probe.fields.size(), 2u);
  EXPECT_EQ(probe.fields[1].text, "u");
  EXPECT_EQ(probe.fields[1].line, 3);
  EXPECT_EQ(probe.accuracy, INSITU_FAST);
  const std::vector<TableFormat> formats{TableFormat::vtp, TableFormat::csv, TableFormat::json};
  EXPECT_EQ(probe.output, formats);
  EXPECT_EQ(parse(test::probe("accuracy: standard")).probes[0].accuracy, INSITU_STANDARD);
  EXPECT_EQ(probe.outside, INSITU_OUTSIDE_NONE);
  const Probe near = parse(test::probe("outside: nearest, greatest_distance: 2.5")).probes[0];
  EXPECT_EQ(near.outside, INSITU_OUTSIDE_NEAREST);
  EXPECT_EQ(near.greatest_distance, 2.5);
}

TEST(SceneKeys, PathsAreRelativeToTheScene) {
  const auto path = [](const std::string& name) {
    return std::get<PointFile>(parse("probes: [{name: p, points: " + name + "}]").probes[0].points)
        .path;
  };
  EXPECT_EQ(path("a.csv"), "/base/a.csv");
  EXPECT_EQ(path("../b/./a.csv"), "/b/a.csv");
  EXPECT_EQ(path("/else/a.csv"), "/else/a.csv");
}

TEST(SceneKeys, PointSources) {
  const auto points = [](const std::string& value) {
    return parse("probes: [{name: p, points: " + value + "}]").probes[0].points;
  };
  const auto list = std::get<PointList>(points("[[0, 1, 2], [+3.5, -4e1, .5]]"));
  ASSERT_EQ(list.points.size(), 2u);
  EXPECT_EQ(list.points[1], (math::Vec3d{3.5, -40, 0.5}));
  EXPECT_EQ(std::get<PointList>(points("{points: [[1, 2, 3]]}")).points.size(), 1u);
  EXPECT_EQ(std::get<PointFile>(points("{points: a.csv}")).path, "/base/a.csv");
  const auto line = std::get<Line>(points("{line: {from: [0, 0, 0], to: [1, 2, 3], count: 7}}"));
  EXPECT_EQ(line.to, (math::Vec3d{1, 2, 3}));
  EXPECT_EQ(line.count, 7);
  const auto transect =
      std::get<Transect>(points("{transect: {from: [4, 5, 6], to: [1, 2, 3], count: 8}}"));
  EXPECT_EQ(transect.from, (math::Vec3d{4, 5, 6}));
  EXPECT_EQ(transect.count, 8);
  const auto curtain = std::get<Curtain>(
      points("{curtain: {through: [[1, 2], [3, 4], [5, 6]], count: 9, levels: [0, 10, 30]}}"));
  EXPECT_EQ(curtain.through, (std::vector<math::Vec3d>{{1, 2, 0}, {3, 4, 0}, {5, 6, 0}}));
  EXPECT_EQ(curtain.count, 9);
  EXPECT_EQ(curtain.levels, (std::vector<double>{0, 10, 30}));
  EXPECT_EQ(std::get<Curtain>(points("{curtain: {through: [[0, 0], [1, 0]], count: 2, levels: "
                                     "{from: 4, to: -4, count: 5}}}"))
                .levels,
            (std::vector<double>{4, 2, 0, -2, -4}));
  const auto plane = std::get<Plane>(
      points("{plane: {origin: [1, 1, 1], u: [2, 0, 0], v: [0, 3, 0], counts: [4, 5]}}"));
  EXPECT_EQ(plane.origin, (math::Vec3d{1, 1, 1}));
  EXPECT_EQ(plane.u, (math::Vec3d{2, 0, 0}));
  EXPECT_EQ(plane.v, (math::Vec3d{0, 3, 0}));
  EXPECT_EQ(plane.counts, (std::array<std::int64_t, 2>{4, 5}));
  for (const char* name : {"grid", "box"}) {
    const auto box = std::get<Box>(
        points("{" + std::string(name) + ": {min: [0, 0, 0], max: [1, 2, 3], counts: [4, 5, 6]}}"));
    EXPECT_EQ(box.max, (math::Vec3d{1, 2, 3}));
    EXPECT_EQ(box.counts, (std::array<std::int64_t, 3>{4, 5, 6}));
  }
  const auto sphere =
      std::get<Sphere>(points("{sphere: {center: [1, 2, 3], radius: 4, count: 5}}"));
  EXPECT_EQ(sphere.center, (math::Vec3d{1, 2, 3}));
  EXPECT_EQ(sphere.radius, 4);
  EXPECT_EQ(sphere.count, 5);
}

TEST(SceneKeys, FramesOfReference) {
  using Kind = FrameOfReference::Kind;
  const auto frame = [](const std::string& value) {
    return parse(test::probe("frame: " + value)).probes[0].frame;
  };
  EXPECT_EQ(frame("mesh").kind, Kind::mesh);
  EXPECT_EQ(frame("cartesian").kind, Kind::cartesian);
  EXPECT_EQ(frame("geocentric").kind, Kind::geocentric);
  EXPECT_EQ(frame("geodetic").kind, Kind::geodetic);
  EXPECT_FALSE(frame("geodetic").depth);
  EXPECT_FALSE(frame("{geodetic: height}").depth);
  EXPECT_TRUE(frame("{geodetic: depth}").depth);
  const auto enu = frame("{enu: [13.4, 52.5, 40]}");
  EXPECT_EQ(enu.kind, Kind::east_north_up);
  EXPECT_EQ(enu.longitude, 13.4);
  EXPECT_EQ(enu.latitude, 52.5);
  EXPECT_EQ(enu.height, 40);
  const auto utm = frame("{utm: 33N}");
  EXPECT_EQ(utm.kind, Kind::utm);
  EXPECT_EQ(utm.zone, 33);
  EXPECT_TRUE(utm.north);
  EXPECT_EQ(frame("{utm: 5S}").zone, 5);
  EXPECT_FALSE(frame("{utm: 5S}").north);
}

TEST(SceneKeys, TracerDefaults) {
  const Tracer tracer = parse("tracers: [{name: t, seeds: [[0, 0, 0]], velocity: u}]").tracers[0];
  EXPECT_EQ(tracer.kind, TracerKind::pathline);
  EXPECT_EQ(tracer.velocity.text, "u");
  EXPECT_EQ(tracer.velocity.line, 2);
  EXPECT_EQ(tracer.integrator.method, IntegrationMethod::dopri5);
  EXPECT_EQ(tracer.integrator.tolerance, 1e-6);
  EXPECT_FALSE(tracer.integrator.face_aware.has_value());
  EXPECT_EQ(tracer.time_interpolation, insitu::advect::TimeInterpolation::linear);
  EXPECT_EQ(tracer.direction, TracerDirection::forward);
  EXPECT_EQ(tracer.integrator.max_steps, 10000);
  EXPECT_FALSE(tracer.integrator.step || tracer.integrator.min_step || tracer.integrator.max_step);
  EXPECT_EQ(tracer.integrator.at_min_step, insitu::advect::AtMinStep::end);
  EXPECT_FALSE(tracer.until.duration || tracer.until.length);
  EXPECT_TRUE(tracer.fields.empty());
  EXPECT_EQ(tracer.accuracy, INSITU_STANDARD);
  EXPECT_EQ(tracer.output, std::vector<TableFormat>{TableFormat::csv});
}

TEST(SceneKeys, TracerKeys) {
  const Tracer tracer =
      parse(test::tracer(
                "mesh: m, frame: geocentric, kind: streamline, fields: [a, b], "
                "direction: both, integrator: {method: dopri5, face_aware: true, step: 0.25, "
                "tolerance: 1e-3, "
                "min_step: 0.125, at_min_step: take, max_step: 0.5, max_steps: 77}, "
                "until: {duration: 3, length: 4}, effects: [], accuracy: exact, "
                "output: [csv, vtp]"))
          .tracers[0];
  EXPECT_EQ(tracer.mesh.text, "m");
  EXPECT_EQ(tracer.frame.kind, FrameOfReference::Kind::geocentric);
  EXPECT_EQ(tracer.kind, TracerKind::streamline);
  EXPECT_EQ(tracer.fields[1].text, "b");
  EXPECT_EQ(tracer.integrator.face_aware, true);
  EXPECT_EQ(tracer.direction, TracerDirection::both);
  EXPECT_EQ(tracer.integrator.step, 0.25);
  EXPECT_EQ(tracer.integrator.tolerance, 1e-3);
  EXPECT_EQ(tracer.integrator.min_step, 0.125);
  EXPECT_EQ(tracer.integrator.at_min_step, insitu::advect::AtMinStep::take);
  EXPECT_EQ(tracer.integrator.max_step, 0.5);
  EXPECT_EQ(tracer.integrator.max_steps, 77);
  EXPECT_EQ(tracer.until.duration, 3);
  EXPECT_EQ(tracer.until.length, 4);
  EXPECT_EQ(tracer.accuracy, INSITU_EXACT);
  EXPECT_EQ(tracer.output.size(), 2u);
  EXPECT_EQ(parse(test::tracer("kind: streamline, spacing: {length: 3}")).tracers[0].spacing.length,
            3);
  EXPECT_EQ(parse(test::tracer("kind: streamline, spacing: {time: 4}")).tracers[0].spacing.time, 4);
  EXPECT_FALSE(tracer.times.interval || tracer.times.from || tracer.times.until);
  const OutputTimes at = parse(test::tracer("times: [-1, 0.5]")).tracers[0].times;
  EXPECT_EQ(at.at, (std::vector<double>{-1, 0.5}));
  const OutputTimes even =
      parse(test::tracer("times: {interval: 0.5, from: -2, until: 7}")).tracers[0].times;
  EXPECT_EQ(even.interval, 0.5);
  EXPECT_EQ(even.from, -2);
  EXPECT_EQ(even.until, 7);
  EXPECT_EQ(parse(test::tracer("time_interpolation: quadratic")).tracers[0].time_interpolation,
            insitu::advect::TimeInterpolation::quadratic);
  EXPECT_EQ(parse(test::tracer("time_interpolation: cubic")).tracers[0].time_interpolation,
            insitu::advect::TimeInterpolation::cubic);
  const Tracer attached = parse("tracers: [{name: t, attached: body, seeds: [[0, 0, 0]], effects: "
                                "[{age_limit: 3}, {remove: {when: density > 2}}]}]")
                              .tracers[0];
  EXPECT_EQ(attached.effects.age_limit, 3);
  EXPECT_EQ(attached.effects.remove->when.text(), "density > 2");
  const Tracer streakline = parse(test::tracer("kind: streakline")).tracers[0];
  EXPECT_EQ(streakline.kind, TracerKind::streakline);
  EXPECT_EQ(streakline.release.every, 1);
  const Release once = parse(test::tracer("kind: streakline, release: once")).tracers[0].release;
  EXPECT_FALSE(once.every || once.interval || once.until);
  const Release timed =
      parse(test::tracer("release: {interval: 0.5, until: -3}")).tracers[0].release;
  EXPECT_EQ(timed.interval, 0.5);
  EXPECT_EQ(timed.until, -3);
  EXPECT_FALSE(timed.every);
  EXPECT_EQ(parse(test::tracer("release: {every: 7}")).tracers[0].release.every, 7);
  const Release waiting = parse(test::tracer("release: {when: cycle > 3}")).tracers[0].release;
  EXPECT_TRUE(waiting.once());
  EXPECT_EQ(waiting.when->text(), "cycle > 3");
  EXPECT_EQ(parse(test::tracer("geodesics: [release_bearing, path_length]")).tracers[0].geodesics,
            (std::vector{TrackGeodesic::release_bearing, TrackGeodesic::path_length}));
  EXPECT_FALSE(parse("every: 2\n").checkpoint.every);
  const CheckpointOptions checkpoint = parse("checkpoint: {every: 50}\n").checkpoint;
  EXPECT_EQ(checkpoint.every, 50);
  EXPECT_EQ(checkpoint.keep, 2);
  EXPECT_EQ(parse("checkpoint: {every: 5, keep: 1}\n").checkpoint.keep, 1);
  EXPECT_FALSE(parse("every: 2\n").record.every);
  EXPECT_EQ(parse("record: {every: 7}\n").record.every, 7);
  EXPECT_EQ(parse("every: 2\n").seam_tolerance, 1e-6);
  EXPECT_EQ(parse("seam_tolerance: 0\n").seam_tolerance, 0.0);
  EXPECT_EQ(parse("seam_tolerance: 1e-3\n").seam_tolerance, 1e-3);
  EXPECT_EQ(parse("every: 2\n").held_steps, 0);
  EXPECT_EQ(parse("hold: {steps: 3}\n").held_steps, 3);
  const SceneDescription seeded =
      parse("probes: [{name: p, mesh: m, points: [[1, 2, 3]], frame: geocentric}]\n"
            "tracers: [{name: t, velocity: u, seeds: {probe: p}}]");
  EXPECT_EQ(std::get<PointList>(seeded.tracers[0].seeds).points[0].y, 2);
  EXPECT_EQ(seeded.tracers[0].frame.kind, FrameOfReference::Kind::geocentric);
  EXPECT_EQ(seeded.tracers[0].mesh.text, "m");
  EXPECT_EQ(parse(test::tracer("integrator: {method: rk4, step: 2}")).tracers[0].integrator.method,
            IntegrationMethod::rk4);
  EXPECT_EQ(parse(test::tracer("integrator: {method: euler}")).tracers[0].integrator.method,
            IntegrationMethod::euler);
  EXPECT_EQ(parse(test::tracer("integrator: {method: bs32}")).tracers[0].integrator.method,
            IntegrationMethod::bs32);
}

TEST(SceneKeys, TracerEffects) {
  const TracerEffects none = parse(test::tracer("")).tracers[0].effects;
  EXPECT_FALSE(none.diffusion || none.settling || none.windage || none.inertia || none.rotation ||
               none.boundary || none.age_limit || none.remove);
  const TracerEffects e =
      parse(
          test::tracer(
              "effects: [{diffusion: {horizontal: kh, vertical: 1e-4, step: 60, seed: 7}}, "
              "{settling: {speed: 0.5, down: [0, 0, 2]}}, {windage: {field: wind, factor: 0.03}}, "
              "{inertia: {diameter: 1e-3, density: 2, fluid_density: 1, viscosity: 1e-3, "
              "gravity: [0, 0, -9.81], added_mass: true, velocity: [1, 2, 3]}}, "
              "{coriolis: {rotation: [0, 0, 1e-4]}}, "
              "{boundary: {periodic: [x, z], other: reflect, restitution: 0.5}}, "
              "{age_limit: 9}, {remove: {when: salt < 5 and age > 3}}]"))
          .tracers[0]
          .effects;
  EXPECT_EQ(e.diffusion->horizontal.field.text, "kh");
  EXPECT_TRUE(e.diffusion->vertical.field.empty());
  EXPECT_EQ(e.diffusion->vertical.number, 1e-4);
  EXPECT_EQ(e.diffusion->step, 60);
  EXPECT_EQ(e.diffusion->seed, 7);
  EXPECT_EQ(e.settling->speed.number, 0.5);
  EXPECT_EQ(e.settling->down.value().z, 1.0);
  EXPECT_EQ(e.windage->field.text, "wind");
  EXPECT_EQ(e.windage->factor, 0.03);
  EXPECT_EQ(e.inertia->diameter, 1e-3);
  EXPECT_TRUE(e.inertia->added_mass);
  EXPECT_EQ(e.inertia->velocity->y, 2);
  EXPECT_EQ(e.rotation->z, 1e-4);
  EXPECT_TRUE(e.boundary->periodic[0] && !e.boundary->periodic[1] && e.boundary->periodic[2]);
  EXPECT_EQ(e.boundary->other, WallResponse::reflect);
  EXPECT_EQ(e.boundary->restitution, 0.5);
  EXPECT_EQ(e.age_limit, 9);
  ASSERT_EQ(e.remove->when.uses().size(), 1u);
  EXPECT_EQ(e.remove->when.uses()[0].field, "salt");
  EXPECT_EQ(parse(test::tracer("effects: [{boundary: slide}]")).tracers[0].effects.boundary->other,
            WallResponse::slide);
  EXPECT_EQ(parse(test::tracer("effects: [{boundary: {other: put_back}}]"))
                .tracers[0]
                .effects.boundary->other,
            WallResponse::put_back);
}

TEST(SceneKeys, DefaultScene) {
  const SceneDescription scene = default_scene("density", "hydro");
  EXPECT_EQ(scene.trigger.every, 10);
  ASSERT_EQ(scene.frames.size(), 1u);
  EXPECT_TRUE(scene.probes.empty() && scene.tracers.empty());
  const Frame& frame = scene.frames[0];
  EXPECT_EQ(frame.trigger.every, 10);
  EXPECT_EQ(frame.layers[0].mesh.text, "hydro");
  EXPECT_EQ(frame.layers[0].volume->field.text, "density");
  EXPECT_FALSE(frame.camera.position);
  EXPECT_TRUE(frame.scalar_bar && frame.time_label);
}

TEST(SceneFile, IsReadWithItsFolder) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "insitu_scene_file";
  std::filesystem::create_directories(folder);
  const auto path = folder / "scene.yaml";
  std::ofstream(path) << "insitu: 1\nprobes: [{name: p, points: a.csv}]\n";
  const SceneDescription scene = parse_scene_file(path.string());
  EXPECT_EQ(scene.file, path.string());
  EXPECT_EQ(std::get<PointFile>(scene.probes[0].points).path, (folder / "a.csv").string());
  std::ofstream(path) << "insitu: 1\n" << std::string(3 << 20, '#');
  EXPECT_NE(test::error_of_call([&] { parse_scene_file(path.string()); }).find("more than 1048576"),
            std::string::npos);
}

TEST(SceneFile, ThatCannotBeReadIsNamed) {
  for (const std::string path : {"/nowhere/scene.yaml", "/"}) {
    try {
      parse_scene_file(path);
      FAIL() << path;
    } catch (const core::Error& error) {
      EXPECT_EQ(error.status(), INSITU_ERROR_FILE);
      EXPECT_NE(std::string(error.what()).find("'" + path + "'"), std::string::npos);
    }
  }
}

TEST(SceneFile, TheCorpusOfTheFuzzTestIsValidWhereItShouldBe) {
  const std::string folder = INSITU_SCENE_CORPUS;
  for (const char* name : {"design.yaml", "everything.yaml", "aliases.yaml"}) {
    EXPECT_NO_THROW(parse_scene_file(folder + "/" + name)) << name;
  }
}
