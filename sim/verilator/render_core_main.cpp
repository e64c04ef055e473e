// SPDX-License-Identifier: Apache-2.0
//
// Writes the state of a file (address and word, 32 bits each), then feeds the core from a file of set-up
// beats (set-up words of 32 bits, the first one lowest) and writes the pixels it emits as records (struct
// Record below, which engine/verilator.py reads). Stream always valid; the sink is ready but for one clock in
// STALL_PERIOD, counted from the first beat (0: always). Prints "clocks N" (first beat accepted to last pixel
// out, both included), "cycles N" (all that were simulated, from reset to idle) and "seconds T" (the
// simulation with its reading and writing).
//
//   render_core STATE BEATS PIXELS STALL_PERIOD
//
// The core's generics come as macros: STREAM_WIDTH, EMITTED_CHANNELS, VALUE_BITS.

#include <chrono>
#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "Vrender_core.h"
#include "verilated.h"

namespace {

constexpr unsigned setup_word_bits = 32;
constexpr size_t beat_words = STREAM_WIDTH / setup_word_bits;
// A packet has fewer than 2^15 scanlines: a core that takes no beat and emits no pixel for so long hangs.
constexpr uint64_t patience = 1 << 20;
constexpr size_t block_records = 1 << 16;

struct Record {
    uint16_t x;
    uint16_t y;
    uint32_t depth;
    uint32_t value[EMITTED_CHANNELS];
    uint16_t last;
};

[[noreturn]] void fail(const char* what, const char* name) {
    std::fprintf(stderr, "error: %s %s\n", what, name);
    std::exit(1);
}

struct Close {
    void operator()(FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<FILE, Close>;

File open_file(const char* name, const char* mode) {
    File file(std::fopen(name, mode));
    if (!file) fail("cannot open", name);
    return file;
}

// Ports of up to 64 bits are plain integers, wider ones have words of 32 bits.
template <typename T> void put_beat(T& port, const uint32_t* words) {
    uint64_t bits = words[0];
    if constexpr (sizeof(T) > sizeof(uint32_t)) bits |= uint64_t(words[1]) << setup_word_bits;
    port = T(bits);
}

template <size_t N> void put_beat(VlWide<N>& port, const uint32_t* words) {
    for (size_t index = 0; index < N; ++index) port[index] = words[index];
}

template <typename T> uint32_t get_bits(const T& port, unsigned low, unsigned width) {
    return uint32_t(uint64_t(port) >> low) & ((UINT64_C(1) << width) - 1);
}

template <size_t N> uint32_t get_bits(const VlWide<N>& port, unsigned low, unsigned width) {
    const size_t word = low / setup_word_bits;
    const unsigned shift = low % setup_word_bits;
    uint64_t bits = port[word];
    if (shift + width > setup_word_bits) bits |= uint64_t(port[word + 1]) << setup_word_bits;
    return uint32_t(bits >> shift) & ((UINT64_C(1) << width) - 1);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 5) fail("usage:", "render_core STATE BEATS PIXELS STALL_PERIOD");
    File state = open_file(argv[1], "rb");
    File beats = open_file(argv[2], "rb");
    File pixels = open_file(argv[3], "wb");
    const uint64_t stall_period = std::strtoull(argv[4], nullptr, 10);

    VerilatedContext context;
    Vrender_core core(&context);
    uint64_t cycle = 0, first_beat = 0, last_pixel = 0, last_change = 0;
    uint32_t beat[beat_words];
    std::vector<Record> block;
    block.reserve(block_records);
    bool started = false;
    const auto start = std::chrono::steady_clock::now();

    const auto rise = [&] {
        core.clk = 1;
        core.eval();
        ++cycle;
    };
    const auto settle = [&] {
        core.clk = 0;
        core.eval();
    };
    const auto write_block = [&] {
        if (std::fwrite(block.data(), sizeof(Record), block.size(), pixels.get()) != block.size())
            fail("cannot write", argv[3]);
        block.clear();
    };
    const auto read_beat = [&] {
        core.setup_valid = std::fread(beat, sizeof beat, 1, beats.get()) == 1;
        if (core.setup_valid) put_beat(core.setup_data, beat);
    };

    core.reset = 1;
    core.setup_valid = 0;
    core.state_valid = 0;
    core.pixel_ready = 1;
    settle();
    rise();
    core.reset = 0;
    core.state_valid = 1;
    uint32_t write[2];
    while (std::fread(write, sizeof write, 1, state.get()) == 1) {
        core.state_address = write[0];
        core.state_data = write[1];
        settle();
        if (!core.state_ready) fail("the core hangs:", "it is idle and takes no state");
        rise();
    }
    core.state_valid = 0;
    read_beat();
    settle();
    // Between two rising edges everything has settled: what is seen here is what the next edge takes.
    while (core.setup_valid || !core.idle) {
        const bool taken = core.setup_valid && core.setup_ready;
        const bool emitted = core.pixel_valid && core.pixel_ready;
        if (taken && !started) {
            started = true;
            first_beat = cycle;
        }
        if (emitted) {
            Record record;
            record.x = core.pixel_x;
            record.y = core.pixel_y;
            record.depth = core.pixel_depth;
            for (unsigned channel = 0; channel < EMITTED_CHANNELS; ++channel)
                record.value[channel] = get_bits(core.pixel_value, channel * VALUE_BITS, VALUE_BITS);
            record.last = core.pixel_last;
            block.push_back(record);
            if (block.size() == block_records) write_block();
            last_pixel = cycle + 1;
        }
        if (taken || emitted) last_change = cycle;
        if (cycle - last_change > patience) fail("the core hangs:", "no beat taken and no pixel emitted");
        rise();
        if (taken) read_beat();
        if (started && stall_period) core.pixel_ready = (cycle - first_beat + 1) % stall_period != 0;
        settle();
    }

    write_block();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    if (std::ferror(beats.get())) fail("cannot read", argv[2]);
    if (std::ferror(state.get())) fail("cannot read", argv[1]);
    if (std::fflush(pixels.get())) fail("cannot write", argv[3]);
    core.final();
    std::printf("clocks %" PRIu64 "\n", last_pixel - (last_pixel ? first_beat : 0));
    std::printf("cycles %" PRIu64 "\n", cycle);
    std::printf("seconds %.6f\n", seconds.count());
}
