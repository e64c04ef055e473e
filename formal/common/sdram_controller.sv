// SPDX-License-Identifier: Apache-2.0
//
// sdram_controller against the chip's data sheet. The chip knows no reset: its row, and the clocks since each
// command, are counted here through all of them. A run is done as it was asked; refreshes come in time.

module sdram_controller_properties #(
  parameter data_bits = 16,
  parameter bank_bits = 2,
  parameter row_bits = 13,
  parameter column_bits = 9,
  parameter run_words = 64,
  parameter cas_clocks = 3,
  parameter rcd_clocks = 3,
  parameter rp_clocks = 3,
  parameter ras_clocks = 5,
  parameter rc_clocks = 7,
  parameter rfc_clocks = 7,
  parameter mrd_clocks = 2,
  parameter wr_clocks = 2,
  parameter refresh_clocks = 780,
  parameter power_up_refreshes = 26
) (
  input clk,
  input reset,
  input first_valid,
  input [row_bits + bank_bits + column_bits - 1:0] first_address,
  input [$clog2(run_words) - 1:0] first_more,
  input second_valid,
  input second_write,
  input [row_bits + bank_bits + column_bits - 1:0] second_address,
  input [$clog2(run_words) - 1:0] second_more,
  input [data_bits - 1:0] write_data,
  input write_keep,
  input [data_bits - 1:0] sdram_data_in
);

  wire first_ready, second_ready, first_data_valid, second_data_valid, write_next;
  wire [data_bits - 1:0] read_data, sdram_data_out;
  wire ras_n, cas_n, we_n, mask, drive;
  wire [bank_bits - 1:0] bank;
  wire [row_bits - 1:0] address;

  sdram_controller dut (
    .clk(clk), .reset(reset),
    .first_valid(first_valid), .first_ready(first_ready), .first_address(first_address),
    .first_more(first_more), .first_data_valid(first_data_valid),
    .second_valid(second_valid), .second_ready(second_ready), .second_write(second_write),
    .second_address(second_address), .second_more(second_more), .second_data_valid(second_data_valid),
    .write_next(write_next), .write_data(write_data), .write_keep(write_keep), .read_data(read_data),
    .sdram_ras_n(ras_n), .sdram_cas_n(cas_n), .sdram_we_n(we_n), .sdram_mask(mask), .sdram_bank(bank),
    .sdram_address(address), .sdram_drive(drive), .sdram_data_out(sdram_data_out),
    .sdram_data_in(sdram_data_in)
  );

  // As the unit derives them.
  localparam read_close = ras_clocks > rcd_clocks + 1 ? ras_clocks - rcd_clocks : 1;
  localparam write_close = wr_clocks > read_close ? wr_clocks : read_close;
  localparam pause_1 = rcd_clocks > rp_clocks ? rcd_clocks : rp_clocks;
  localparam pause_2 = rfc_clocks > mrd_clocks ? rfc_clocks : mrd_clocks;
  localparam pause_3 = pause_1 > pause_2 ? pause_1 : pause_2;
  localparam most_pause = pause_3 > write_close ? pause_3 : write_close;
  localparam left_1 = run_words > 8 ? run_words : 8;
  localparam most_left = left_1 > power_up_refreshes ? left_1 : power_up_refreshes;
  localparam most_rank = rcd_clocks - 1 + run_words + write_close + rp_clocks - 1;
  localparam power_up_clocks = power_up_refreshes * refresh_clocks;

  localparam most = 8;

  localparam rests = 0, closes = 1, refreshes = 2, sets = 3, waits = 4, moves = 5, ends = 6;
  (* hierconn *) wire [2:0] \dut.state ;
  (* hierconn *) wire [$clog2(most_pause) - 1:0] \dut.pause ;
  (* hierconn *) wire [$clog2(most_left) - 1:0] \dut.left ;
  (* hierconn *) wire [$clog2(refresh_clocks) - 1:0] \dut.interval ;
  (* hierconn *) wire \dut.tick ;
  (* hierconn *) wire \dut.due ;
  (* hierconn *) wire \dut.writes ;
  (* hierconn *) wire \dut.second ;
  (* hierconn *) wire [column_bits - 1:0] \dut.column ;
  (* hierconn *) wire [cas_clocks + 1:0] \dut.first_coming ;
  (* hierconn *) wire [cas_clocks + 1:0] \dut.second_coming ;
  wire [15:0] state = \dut.state , pause = \dut.pause , left = \dut.left , interval = \dut.interval ;

  wire [2:0] command = {ras_n, cas_n, we_n};
  wire is_mode = command == 3'b000, is_refresh = command == 3'b001, is_close = command == 3'b010;
  wire is_open = command == 3'b011, is_write = command == 3'b100, is_read = command == 3'b101;
  wire is_any = command != 3'b111;

  // Clocks since each, up to more than any time; of a command in this clock none have gone by.
  function [3:0] older(input [3:0] clocks);
    older = clocks == most ? most : clocks + 1;
  endfunction
  reg [3:0] opened = most, closed = most, refreshed = most, set = most, written = most;
  wire [15:0] now_opened = is_open ? 0 : opened, now_closed = is_close ? 0 : closed;
  wire [15:0] now_refreshed = is_refresh ? 0 : refreshed, now_set = is_mode ? 0 : set;
  wire [15:0] now_written = is_write ? 0 : written;
  // After power-up a row may be open.
  reg row_open = 1, mode_set = 0, running = 0;
  wire now_open = is_open || row_open && !is_close, now_mode = mode_set || is_mode;
  reg [bank_bits - 1:0] open_bank;
  wire [bank_bits - 1:0] now_bank = is_open ? bank : open_bank;
  // Since power-up; refreshes since then; clocks since the last one, while there are more than the mode's.
  reg [15:0] age = 0, gap = 0;
  reg [3:0] count = 0;
  wire [3:0] now_count = count + (is_refresh && count != 8);
  wire now_running = running || is_refresh && state == waits;
  wire [15:0] now_gap = is_refresh ? 0 : gap;

  always @(posedge clk) begin
    opened <= older(now_opened[3:0]);
    closed <= older(now_closed[3:0]);
    refreshed <= older(now_refreshed[3:0]);
    set <= older(now_set[3:0]);
    written <= older(now_written[3:0]);
    row_open <= now_open;
    open_bank <= now_bank;
    mode_set <= now_mode;
    count <= now_count;
    age <= age == power_up_clocks ? age : age + 1;
    // A reset is not what a refresh waits for.
    running <= now_running && !reset && state >= waits;
    gap <= now_gap + 1;
  end

  always @* begin
    // The data sheet's times and order.
    if (is_any) assert (age == power_up_clocks && refreshed >= rfc_clocks && set >= mrd_clocks);
    if (is_open) assert (!row_open && mode_set && closed >= rp_clocks && opened >= rc_clocks);
    if (is_read || is_write) begin
      assert (row_open && mode_set && bank == open_bank && opened >= rcd_clocks);
      assert (address >> column_bits == 0 && address[10] == 0);
    end
    if (is_read) assert (!mask);
    if (is_close) assert (opened >= ras_clocks && written >= wr_clocks && address[10]);
    if (is_refresh || is_mode) assert (!row_open && closed >= rp_clocks);
    if (is_mode) assert (count == 8 && address == 16 * cas_clocks && bank == 0);
    assert (drive == is_write);
  end

  // What makes that inductive: the next command comes pause + 1 clocks from now at the earliest.
  wire [15:0] coming = pause + 1;
  wire [15:0] rested = refresh_clocks - 1 - interval;
  wire fresh = left == power_up_refreshes - 1 && !\dut.tick ;
  wire [3:0] least = !fresh || rested > most ? most : rested;
  wire in_row = state == moves || state == ends;
  always @* begin
    assert (state <= ends && interval < refresh_clocks && pause < most_pause);
    assert (age <= power_up_clocks && opened <= most && closed <= most);
    assert (refreshed <= most && set <= most && written <= most && command != 3'b110 && count <= 8);
    if (\dut.tick ) assert (interval == refresh_clocks - 1);
    if (state <= closes) assert (pause == 0 && !is_any);
    if (state == rests) begin
      assert (opened >= least && closed >= least && refreshed >= least && set >= least && written >= least);
      assert (left < power_up_refreshes);
      if (age != power_up_clocks)
        assert (age >= (power_up_refreshes - 1 - left) * refresh_clocks + rested
                + (\dut.tick ? refresh_clocks : 0));
    end
    if (state == closes) assert (opened == most && written == most && refreshed == most && set == most);
    if (state == closes) assert (left == 7);
    if (state != rests) assert (age == power_up_clocks);
    if (state == refreshes) assert (left < 8 && now_count + left + 1 >= 8);
    if (state >= sets) assert (now_count == 8);
    if (state >= refreshes) begin
      assert (now_closed + coming >= rp_clocks && now_refreshed + coming >= rfc_clocks);
      assert (now_set + coming >= mrd_clocks && now_open == in_row);
    end
    if (state >= waits) assert (now_mode);
    if (state == waits || state == moves && !\dut.writes || is_open) assert (!mask);
    if (state >= refreshes && !in_row) assert (now_opened + coming >= rc_clocks);
    if (in_row) assert (now_bank == bank);
    if (state == moves) assert (now_opened + coming >= rcd_clocks && left < run_words);
    if (state == ends) assert (now_opened + coming >= ras_clocks && now_written + coming >= wr_clocks);
    if (is_read || is_write) assert (in_row);
    if (now_running) assert (state >= waits);
  end

  // A refresh follows each interval's end, before the next one's; rank: clocks until one can be decided.
  wire [15:0] rank = state == waits ? pause : state == ends ? pause + rp_clocks
    : pause + left + (\dut.writes ? write_close : read_close) + rp_clocks;
  always @* begin
    if (state != rests && state < waits || state == rests && !fresh) assert (\dut.due );
    if (now_running) begin
      if (\dut.due ) assert (rested + rank <= most_rank && now_gap <= refresh_clocks + rested);
      else assert (now_gap <= rested);
      assert (rank <= most_rank);
      assert (now_gap <= refresh_clocks + most_rank + 1);
    end else if (state >= waits) assert (\dut.due && state == waits);
  end

  // The first port does not wait longer than for a run and a refresh.
  reg [15:0] waited = 0;
  always @(posedge clk)
    waited <= now_running && first_valid && !first_ready && !reset ? waited + 1 : 0;
  wire [15:0] wait_left = rank + (\dut.due || interval < rank ? rfc_clocks : 0);
  always @* begin
    if (waited != 0) assert (now_running);
    if (now_running) assert (waited + wait_left <= most_rank + rfc_clocks + 1);
    assert (waited <= most_rank + rfc_clocks + 1);
  end

  // A run: its row is opened, then its columns follow, then nothing but the next run.
  reg [row_bits + bank_bits + column_bits - 1:0] asked = 0;
  reg [15:0] words = 0;
  reg asked_write = 0, asked_second = 0, accepted = 0;
  wire takes = first_valid && first_ready || second_valid && second_ready;
  wire [column_bits - 1:0] asked_column = asked[column_bits - 1:0];
  wire moved = is_read || is_write;
  always @(posedge clk) begin
    accepted <= takes && !reset;
    if (moved) begin
      asked[column_bits - 1:0] <= asked_column + 1;
      words <= words - 1;
    end
    if (takes) begin
      asked <= first_valid ? first_address : second_address;
      words <= first_valid ? first_more + 1 : second_more + 1;
      asked_write <= !first_valid && second_write;
      asked_second <= !first_valid;
    end
    if (reset) words <= 0;
  end
  always @* begin
    assert (is_open == accepted && !(first_ready && second_ready && first_valid));
    if (is_open) assert ({address, bank} == asked >> column_bits && words != 0);
    if (moved)
      assert (words != 0 && address == asked_column && is_write == asked_write);
    if (takes) assert (words == 0);
    if (state == moves) assert (words == left + 1 + moved && \dut.column == asked_column + moved);
    else assert (words == moved);
    if (in_row) assert (\dut.writes == asked_write && \dut.second == asked_second);
  end

  // A word that is read comes to the port that asked, after a fixed time.
  reg [cas_clocks + 1:0] reads_first = 0, reads_second = 0;
  wire [cas_clocks + 1:0] now_first = reads_first | (is_read && !asked_second);
  wire [cas_clocks + 1:0] now_second = reads_second | (is_read && asked_second);
  always @(posedge clk) begin
    reads_first <= reset ? 0 : now_first << 1;
    reads_second <= reset ? 0 : now_second << 1;
  end
  integer place;
  always @* begin
    assert (first_data_valid == now_first[cas_clocks + 1] && second_data_valid == now_second[cas_clocks + 1]);
    for (place = 0; place <= cas_clocks + 1; place = place + 1) begin
      assert (\dut.first_coming [cas_clocks + 1 - place] == now_first[place]);
      assert (\dut.second_coming [cas_clocks + 1 - place] == now_second[place]);
    end
  end

  reg [data_bits - 1:0] taken = 0, given = 0;
  reg kept = 0;
  always @(posedge clk) begin
    taken <= write_data;
    kept <= write_keep;
    given <= sdram_data_in;
  end
  reg next = 0;
  always @(posedge clk) next <= write_next && !reset;
  always @* begin
    assert (next == is_write && read_data == given);
    if (is_write) assert (sdram_data_out == taken && mask == kept);
  end

endmodule
