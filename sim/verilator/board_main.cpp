// SPDX-License-Identifier: Apache-2.0
//
// The whole board between its UART pins: bytes from standard input go to rx as 8N1, bit by bit, what comes
// from tx goes to standard output. Ends when standard input does.
//
//   board CLOCK_HZ BAUD
//
// Standard input is records: a number n from 1 to 255, then n bytes for the line; or 0, then a baud rate
// in four bytes, lowest first, with which the line goes on behind the bytes before it. A rate of 0 asks
// for a line on standard error: "clocks N sending N receiving N", clocks since reset, those with a byte on
// its way to rx, and those with one from tx.

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <vector>

#include "Vboard.h"
#include "verilated.h"

namespace {

// Standard input is looked at so often while bytes wait for the line, and while none do.
constexpr unsigned busy_clocks = 8192, quiet_clocks = 256;
// A board that has nothing to say for so long after the line's last byte waits for the next one, and stands
// still.
constexpr uint64_t idle_clocks = 1 << 22;
constexpr size_t enough_bytes = 1 << 14, block_bytes = 1 << 12;
constexpr unsigned data_bits = 8;

[[noreturn]] void fail(const char* what) {
    std::fprintf(stderr, "error: %s\n", what);
    std::exit(1);
}

// What standard input asks for, in order: a byte for the line, or a rate.
struct Item {
    bool is_rate;
    uint32_t value;
};

class Input {
  public:
    std::deque<Item> items;

    // Takes what is there; waits for it where asked to. False once standard input has ended.
    bool read(bool wait) {
        pollfd ready{STDIN_FILENO, POLLIN, 0};
        if (::poll(&ready, 1, wait ? -1 : 0) <= 0) return true;
        uint8_t block[block_bytes];
        const ssize_t count = ::read(STDIN_FILENO, block, sizeof block);
        if (count < 0 && errno == EINTR) return true;
        if (count <= 0) return false;
        for (ssize_t at = 0; at < count; ++at) add(block[at]);
        return true;
    }

  private:
    void add(uint8_t byte) {
        if (rate_bytes) {
            rate |= uint32_t(byte) << (8 * (4 - rate_bytes));
            if (--rate_bytes == 0) items.push_back({true, rate});
        } else if (data_bytes) {
            --data_bytes;
            items.push_back({false, byte});
        } else if (byte) {
            data_bytes = byte;
        } else {
            rate_bytes = 4;
            rate = 0;
        }
    }

    unsigned data_bytes = 0, rate_bytes = 0;
    uint32_t rate = 0;
};

// A transmitter: a bit lasts clock / baud clocks, exactly on average.
class Sender {
  public:
    bool busy = false;

    void start(uint8_t byte) {
        busy = true;
        // Stop bit above, start bit below.
        bits = (1u << (data_bits + 1)) | unsigned(byte) << 1;
        left = data_bits + 2;
    }
    // The line's level for this clock.
    bool level(uint64_t clock, uint64_t baud) {
        if (!busy) return true;
        const bool now = bits & 1;
        phase += baud;
        if (phase >= clock) {
            phase -= clock;
            bits >>= 1;
            if (--left == 0) busy = false;
        }
        return now;
    }

  private:
    unsigned bits = 0, left = 0;
    uint64_t phase = 0;
};

// A receiver that samples in the middle of bits, from the start bit's edge on.
class Receiver {
  public:
    bool busy = false;

    // True when a byte is complete.
    bool take(bool level, uint64_t clock, uint64_t baud) {
        if (!busy) {
            if (level) return false;
            busy = true;
            position = 0;
            phase = clock / 2;
            byte = 0;
        }
        phase += baud;
        if (phase < clock) return false;
        phase -= clock;
        const unsigned at = position++;
        if (at == 0) busy = !level;
        else if (at <= data_bits) byte |= unsigned(level) << (at - 1);
        else {
            busy = false;
            return level;
        }
        return false;
    }
    uint8_t byte = 0;

  private:
    unsigned position = 0;
    uint64_t phase = 0;
};

// An SDRAM of words of 16 bits with a CAS latency of three, whose times nobody checks here.
class Sdram {
  public:
    // One clock edge at the pins as they stand before it; what stands on the data pins after it.
    uint16_t clock(unsigned command, bool mask, unsigned bank, unsigned address, uint16_t data) {
        const uint16_t now = leaving;
        leaving = following;
        if (command == activate) {
            if (words.empty()) words.resize(size_t(1) << (bank_bits + row_bits + column_bits));
            rows[bank] = address;
        } else if (command == read || command == write) {
            if (words.empty()) fail("the SDRAM is used before a row is open");
            const size_t row = size_t(bank) << row_bits | rows[bank];
            uint16_t& word = words[row << column_bits | (address & ((1u << column_bits) - 1))];
            if (command == read) following = word;
            else if (!mask) word = data;
        }
        return now;
    }

  private:
    // As many as any board's; RAS, CAS and WE, low active.
    static constexpr unsigned bank_bits = 2, row_bits = 13, column_bits = 10;
    static constexpr unsigned activate = 0b011, read = 0b101, write = 0b100;
    std::vector<uint16_t> words;
    unsigned rows[1 << bank_bits] = {};
    uint16_t leaving = 0, following = 0;
};

void write_out(std::vector<uint8_t>& bytes) {
    size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t count = ::write(STDOUT_FILENO, bytes.data() + done, bytes.size() - done);
        if (count < 0 && errno != EINTR) std::exit(0);
        if (count > 0) done += size_t(count);
    }
    bytes.clear();
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) fail("usage: board CLOCK_HZ BAUD");
    const uint64_t clock = std::strtoull(argv[1], nullptr, 10);
    uint64_t baud = std::strtoull(argv[2], nullptr, 10);
    if (!clock || !baud || baud > clock) fail("a clock and a baud rate that is at most as high are needed");

    VerilatedContext context;
    Vboard board(&context);
    Input input;
    Sender sender;
    Receiver receiver;
    Sdram sdram;
    std::vector<uint8_t> output;
    uint64_t clocks = 0, sending = 0, receiving = 0, last_change = 0;
    unsigned until_look = 0;

    const auto cycle = [&] {
        const uint16_t word = sdram.clock(board.sdram_command, board.sdram_mask, board.sdram_bank,
                                          board.sdram_address, board.sdram_data_out);
        board.clk = 1;
        board.eval();
        board.sdram_data_in = word;
        board.clk = 0;
        board.eval();
    };
    board.rx = 1;
    board.reset = 1;
    board.clk = 0;
    board.eval();
    cycle();
    cycle();
    board.reset = 0;
    board.eval();

    for (;;) {
        if (until_look == 0) {
            const bool idle = input.items.empty() && !sender.busy && clocks - last_change > idle_clocks;
            if (idle) write_out(output);
            if (input.items.size() < enough_bytes && !input.read(idle)) break;
            if (idle) last_change = clocks;
            until_look = input.items.empty() ? quiet_clocks : busy_clocks;
        }
        --until_look;
        while (!sender.busy && !input.items.empty()) {
            const Item item = input.items.front();
            input.items.pop_front();
            if (!item.is_rate) sender.start(uint8_t(item.value));
            else if (item.value) baud = item.value < clock ? item.value : clock;
            else
                std::fprintf(stderr, "clocks %" PRIu64 " sending %" PRIu64 " receiving %" PRIu64 "\n", clocks,
                             sending, receiving);
        }
        if (sender.busy) {
            ++sending;
            last_change = clocks;
        }
        board.rx = sender.level(clock, baud);
        cycle();
        ++clocks;
        if (receiver.take(board.tx, clock, baud)) {
            output.push_back(receiver.byte);
            // A frame's end, or a lot of bytes, goes out at once.
            if (receiver.byte == 0 || output.size() >= block_bytes) write_out(output);
        }
        if (receiver.busy) {
            ++receiving;
            last_change = clocks;
        }
    }
    board.final();
}
