#include <fstream>
#include <iostream>

#include "assur/machine.hpp"
#include "commands/commands.hpp"
#include "commands/interrupt.hpp"
#include "output/progress.hpp"
#include "tuning/campaign.hpp"
#include "tuning/sample_csv.hpp"

namespace assur::command {

int tune(const Common& common, const TuneOptions& options) {
  tuning::CampaignOptions how;
  how.field.table = assur::backends();
  how.field.budget = common.threads > 0 ? ThreadBudget{common.threads} : this_machine().budget();
  how.seconds = options.budget.value_or(60);
  std::vector<Sample> samples;
  how.store = [&](const tuning::CellResult& cell) {
    for (const tuning::Result& r : cell.results) samples.push_back(r.sample);
    std::cerr << to_string(cell.cell) << ": " << cell.results.size() << " samples, " << cell.refused.size()
              << " refused" << (cell.cut_short ? ", cut short" : "") << '\n';
    for (const auto& r : cell.refused)
      std::cerr << "    " << name(r.candidate.kernel) << ' ' << to_string(r.candidate.strategy) << ": " << r.why
                << '\n';
  };
  measure::Instruments instruments;
  const Interrupt interrupt;
  instruments.stop = [] { return Interrupt::requested(); };
  tuning::Campaign campaign(how, instruments);
  std::vector<tuning::Cell> cells;
  for (const std::string& text : options.scenes) {
    for (tuning::Cell& c : tuning::scene_cells(text, open_scene(text))) cells.push_back(std::move(c));
  }
  if (cells.empty()) cells = tuning::general_cells({});
  campaign.run(cells);
  for (const auto& f : campaign.figures().failures) std::cerr << f << '\n';
  std::cerr << campaign.figures().measured << " of " << campaign.figures().planned << ' ' << samples.size()
            << " samples " << campaign.figures().seconds << " s, disturbed " << campaign.figures().race.disturbed
            << " of " << campaign.figures().race.blocks << '\n';
  if (!options.csv.empty()) {
    std::ofstream out(options.csv);
    tuning::write_csv(out, samples);
  }
  return campaign.figures().interrupted ? kInterrupted : kDone;
}

}  // namespace assur::command
