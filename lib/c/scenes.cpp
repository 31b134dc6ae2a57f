#include <optional>

#include "assur/scene.hpp"
#include "c/handles.hpp"

struct assur_scene {
  assur::Scene scene;
};

using namespace assur;
using assur::c::call;
using assur::c::checked;

namespace {

Scene& scene_of(assur_scene* handle) { return checked(handle, "scene").scene; }

PrepareOptions options_of(const assur_options* options) {
  const assur_options given = c::sized(options, assur_options ASSUR_OPTIONS, "options");
  PrepareOptions out;
  if (given.strategy != nullptr) out.strategy = given.strategy;
  if (given.controlled != nullptr) out.controlled = c::texts(given.controlled, given.controlled_count, "controlled");
  if (given.threads != 0) out.budget = ThreadBudget{given.threads};  // a negative number is refused
  if (given.mode != ASSUR_LATENCY && given.mode != ASSUR_THROUGHPUT) {
    throw Error(Error::Kind::input,
                "mode is " + std::to_string(given.mode) + "; it must be ASSUR_LATENCY (0) or ASSUR_THROUGHPUT (1)");
  }
  out.mode = given.mode == ASSUR_LATENCY ? Mode::latency : Mode::throughput;
  out.accuracy = given.accuracy;
  if (given.without != nullptr) out.without = c::texts(given.without, given.without_count, "without");
  return out;
}

}  // namespace

extern "C" {

std::int32_t assur_scene_open(const char* file_or_sample, assur_scene** scene) {
  return call([&] {
    assur_scene*& out = checked(scene, "scene");
    out = new assur_scene{open_scene(&checked(file_or_sample, "file_or_sample"))};
    return ASSUR_OK;
  });
}

std::int32_t assur_scene_parse(const char* text, std::size_t length, assur_scene** scene) {
  return call([&] {
    assur_scene*& out = checked(scene, "scene");
    out = new assur_scene{parse_scene({&checked(text, "text"), length})};
    return ASSUR_OK;
  });
}

void assur_scene_free(assur_scene* scene) { delete scene; }

std::int32_t assur_scene_write(const assur_scene* scene, const char* file) {
  return call([&] {
    write_scene(checked(scene, "scene").scene, &checked(file, "file"));
    return ASSUR_OK;
  });
}

const char* assur_scene_name(const assur_scene* scene) {
  return scene != nullptr ? scene->scene.name().c_str() : nullptr;
}
std::size_t assur_scene_parameter_count(const assur_scene* scene) {
  return scene != nullptr ? scene->scene.parameters().size() : 0;
}
const char* assur_scene_parameter_name(const assur_scene* scene, std::size_t parameter) {
  return scene != nullptr ? c::name_at(scene->scene.parameters(), parameter) : nullptr;
}

std::int32_t assur_scene_set(assur_scene* scene, const char* const* names, const double* values, std::size_t count) {
  return call([&] {
    Scene& of = scene_of(scene);
    const std::vector<std::string> named = c::texts(names, count, "names");
    if (count > 0) (void)checked(values, "values");
    Parameters parameters;
    for (std::size_t i = 0; i < count; ++i) parameters[named[i]] = values[i];
    of = of.with_values(parameters);
    return ASSUR_OK;
  });
}
std::int32_t assur_scene_set_outputs(assur_scene* scene, const char* const* names, std::size_t count) {
  return call([&] {
    Scene& of = scene_of(scene);
    of = of.with_outputs(c::texts(names, count, "names"));
    return ASSUR_OK;
  });
}
std::int32_t assur_scene_set_time(assur_scene* scene, double start, double end, double step) {
  return call([&] {
    Scene& of = scene_of(scene);
    of = of.with_time({start, end, step});
    return ASSUR_OK;
  });
}

std::int32_t assur_prepare(const assur_scene* scene, const assur_options* options, assur_plan** plan) {
  return call([&] {
    assur_plan*& out = checked(plan, "plan");
    out = new assur_plan{prepare(checked(scene, "scene").scene, options_of(options))};
    return ASSUR_OK;
  });
}

std::int32_t assur_ensemble_new(const assur_scene* scene, const char* const* names, std::size_t name_count,
                                const double* values, std::size_t members, std::size_t member_stride,
                                const assur_options* options, const assur_step_settings* settings,
                                assur_ensemble** ensemble) {
  return call([&] {
    assur_ensemble*& out = checked(ensemble, "ensemble");
    out = new assur_ensemble{Ensemble(checked(scene, "scene").scene, c::texts(names, name_count, "names"),
                                      c::table_of(values, members, member_stride, name_count), options_of(options),
                                      c::settings_of(settings)),
                             name_count};
    return ASSUR_OK;
  });
}

}  // extern "C"
