// What a time was measured on: written before any number.
#pragma once

namespace assur::bench {

// Adds processor, compiler, build type and library versions to the context that Google Benchmark prints and stores.
void describe_machine();

}  // namespace assur::bench
