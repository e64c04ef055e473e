-- SPDX-License-Identifier: Apache-2.0
--
-- The core behind AXI: render_core with AXI4-Stream ports for set-up words and pixels, and AXI4-Lite for the
-- shade unit's state, counters and the generics. docs/reference/axis.md has the layouts.
--
-- Model: quadshade_axis.py.  Test: test_quadshade_axis.py.
-- Latency: that of render_core; so is the throughput, one pixel per cycle.
-- A write to the shade unit is answered when the core takes it, so while it draws the bus waits.

library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

use work.quadshade_pkg.all;
use work.axis_pkg.all;

entity quadshade_axis is
  generic (
    num_channels : positive := default_formats.num_channels;
    max_order : natural := default_formats.max_order;
    with_depth : natural := default_formats.with_depth;
    word_width : positive := default_formats.word_width;
    frac_bits : natural := default_formats.frac_bits;
    value_bits : positive := default_formats.value_bits;
    depth_bits : positive := default_formats.depth_bits;
    subpixel_bits : natural := default_formats.subpixel_bits;
    coord_bits : positive := default_formats.coord_bits;
    stream_width : positive := default_formats.stream_width;
    span_depth : positive := default_formats.span_depth;
    with_shade : natural := default_formats.with_shade;
    num_specular : positive := default_formats.num_specular;
    shade_guard_bits : positive := default_formats.shade_guard_bits;
    -- Bits of a pixel's tdata, 8 * pixel_data_bytes: 128 for the default generics.
    pixel_width : positive := 128
  );
  port (
    aclk : in std_ulogic;
    aresetn : in std_ulogic;

    s_axis_setup_tvalid : in std_ulogic;
    s_axis_setup_tready : out std_ulogic;
    s_axis_setup_tdata : in std_ulogic_vector(stream_width - 1 downto 0);
    -- What follows begins a packet; low throughout is right too, for a packet says itself how long it is.
    s_axis_setup_tlast : in std_ulogic := '0';

    m_axis_pixel_tvalid : out std_ulogic;
    m_axis_pixel_tready : in std_ulogic;
    m_axis_pixel_tdata : out std_ulogic_vector(pixel_width - 1 downto 0);
    m_axis_pixel_tkeep : out std_ulogic_vector(pixel_width / 8 - 1 downto 0);
    -- The last, the first pixel of a primitive.
    m_axis_pixel_tlast : out std_ulogic;
    m_axis_pixel_tuser : out std_ulogic_vector(0 downto 0);

    -- Left open, the registers are not used; a core without shade needs none.
    s_axil_awvalid : in std_ulogic := '0';
    s_axil_awready : out std_ulogic;
    s_axil_awaddr : in std_ulogic_vector(axi_address_bits - 1 downto 0) := (others => '0');
    s_axil_wvalid : in std_ulogic := '0';
    s_axil_wready : out std_ulogic;
    s_axil_wdata : in std_ulogic_vector(axi_data_bits - 1 downto 0) := (others => '0');
    s_axil_wstrb : in std_ulogic_vector(axi_data_bits / 8 - 1 downto 0) := (others => '1');
    s_axil_bvalid : out std_ulogic;
    s_axil_bready : in std_ulogic := '1';
    s_axil_bresp : out std_ulogic_vector(1 downto 0);
    s_axil_arvalid : in std_ulogic := '0';
    s_axil_arready : out std_ulogic;
    s_axil_araddr : in std_ulogic_vector(axi_address_bits - 1 downto 0) := (others => '0');
    s_axil_rvalid : out std_ulogic;
    s_axil_rready : in std_ulogic := '1';
    s_axil_rdata : out std_ulogic_vector(axi_data_bits - 1 downto 0);
    s_axil_rresp : out std_ulogic_vector(1 downto 0);

    -- No packet begun, no pixel on its way.
    idle : out std_ulogic
  );
end entity;

architecture rtl of quadshade_axis is

  constant formats : formats_t := (
    num_channels => num_channels, max_order => max_order, with_depth => with_depth,
    word_width => word_width, frac_bits => frac_bits, value_bits => value_bits, depth_bits => depth_bits,
    subpixel_bits => subpixel_bits, coord_bits => coord_bits, stream_width => stream_width,
    span_depth => span_depth, with_shade => with_shade, num_specular => num_specular,
    shade_guard_bits => shade_guard_bits
  );
  constant channels : positive := emitted_channels(formats);
  -- A channel in whole bytes.
  constant channel_bits : positive := (value_bits + 7) / 8 * 8;

  constant okay : std_ulogic_vector(1 downto 0) := "00";
  constant slave_error : std_ulogic_vector(1 downto 0) := "10";

  signal reset, core_idle, packet_cut : std_ulogic;
  signal pixel_valid, pixel_taken, pixel_last : std_ulogic;
  signal pixel_x, pixel_y : u_unsigned(coord_bits - 1 downto 0);
  signal pixel_value : u_unsigned(channels * value_bits - 1 downto 0);
  signal pixel_depth : u_unsigned(depth_bits - 1 downto 0);
  signal first_reg : std_ulogic := '1';

  signal state_valid, state_ready : std_ulogic;
  signal state_address : u_unsigned(31 downto 0);

  signal write_offered, write_done, write_is_state : std_ulogic;
  signal answer_reg : std_ulogic := '0';
  signal answer_error_reg : std_ulogic := '0';
  signal read_taken : std_ulogic;
  signal read_reg : std_ulogic := '0';
  signal read_error_reg : std_ulogic := '0';
  signal read_data_reg : u_unsigned(axi_data_bits - 1 downto 0) := (others => '0');
  signal primitives_reg, pixels_reg, cut_packets_reg : u_unsigned(axi_data_bits - 1 downto 0)
    := (others => '0');

begin

  assert pixel_width = 8 * pixel_data_bytes(formats)
    report "quadshade_axis: generic pixel_width is " & integer'image(pixel_width)
      & "; give " & integer'image(8 * pixel_data_bytes(formats))
    severity failure;

  reset <= not aresetn;
  idle <= core_idle;

  core_inst : entity work.render_core
    generic map (
      num_channels => num_channels, max_order => max_order, with_depth => with_depth,
      word_width => word_width, frac_bits => frac_bits, value_bits => value_bits, depth_bits => depth_bits,
      subpixel_bits => subpixel_bits, coord_bits => coord_bits, stream_width => stream_width,
      span_depth => span_depth, with_shade => with_shade, num_specular => num_specular,
      shade_guard_bits => shade_guard_bits, with_last => 1
    )
    port map (
      clk => aclk, reset => reset,
      setup_valid => s_axis_setup_tvalid, setup_ready => s_axis_setup_tready,
      setup_data => s_axis_setup_tdata, setup_last => s_axis_setup_tlast, setup_cut => packet_cut,
      state_valid => state_valid, state_ready => state_ready, state_address => state_address,
      state_data => s_axil_wdata,
      pixel_valid => pixel_valid, pixel_ready => m_axis_pixel_tready, pixel_last => pixel_last,
      pixel_x => pixel_x, pixel_y => pixel_y, pixel_value => pixel_value, pixel_depth => pixel_depth,
      idle => core_idle
    );

  m_axis_pixel_tvalid <= pixel_valid;
  m_axis_pixel_tlast <= pixel_last;
  m_axis_pixel_tuser(0) <= first_reg;
  pixel_taken <= pixel_valid and m_axis_pixel_tready;

  layout : process (all)
  begin
    m_axis_pixel_tdata <= (others => '0');
    m_axis_pixel_tdata(x_low(formats) + coord_bits - 1 downto x_low(formats))
      <= std_ulogic_vector(pixel_x);
    m_axis_pixel_tdata(y_low(formats) + coord_bits - 1 downto y_low(formats))
      <= std_ulogic_vector(pixel_y);
    m_axis_pixel_tdata(depth_low(formats) + depth_bits - 1 downto depth_low(formats))
      <= std_ulogic_vector(pixel_depth);
    for channel in 0 to channels - 1 loop
      m_axis_pixel_tdata(
        value_low(formats) + channel * channel_bits + value_bits - 1
        downto value_low(formats) + channel * channel_bits
      ) <= std_ulogic_vector(pixel_value((channel + 1) * value_bits - 1 downto channel * value_bits));
    end loop;
    for index in m_axis_pixel_tkeep'range loop
      m_axis_pixel_tkeep(index) <= '0';
      if index < pixel_bytes(formats) then
        m_axis_pixel_tkeep(index) <= '1';
      end if;
    end loop;
  end process;

  counters : process (aclk)
  begin
    if rising_edge(aclk) then
      if pixel_taken = '1' then
        first_reg <= pixel_last;
        pixels_reg <= pixels_reg + 1;
        if pixel_last = '1' then
          primitives_reg <= primitives_reg + 1;
        end if;
      end if;
      if packet_cut = '1' then
        cut_packets_reg <= cut_packets_reg + 1;
      end if;
      if reset = '1' then
        first_reg <= '1';
        pixels_reg <= (others => '0');
        primitives_reg <= (others => '0');
        cut_packets_reg <= (others => '0');
      end if;
    end if;
  end process;

  -- A write is taken, address and data together, in the clock in which the shade unit takes it, or refused.
  write_offered <= s_axil_awvalid and s_axil_wvalid and not answer_reg and aresetn;
  write_is_state <= '1' when with_shade = 1 and s_axil_awaddr(axi_address_bits - 1) = '0'
    and s_axil_awaddr(1 downto 0) = "00" and s_axil_wstrb = "1111" else '0';
  state_valid <= write_offered and write_is_state;
  state_address <= resize(unsigned(s_axil_awaddr(axi_address_bits - 2 downto 2)), 32);
  write_done <= write_offered and (state_ready or not write_is_state);
  s_axil_awready <= write_done;
  s_axil_wready <= write_done;
  s_axil_bvalid <= answer_reg;
  s_axil_bresp <= slave_error when answer_error_reg = '1' else okay;

  read_taken <= s_axil_arvalid and not read_reg and aresetn;
  s_axil_arready <= read_taken;
  s_axil_rvalid <= read_reg;
  s_axil_rdata <= std_ulogic_vector(read_data_reg);
  s_axil_rresp <= slave_error when read_error_reg = '1' else okay;

  registers : process (aclk)
    constant generics : natural_vector_t := generic_values(formats);
    variable offset : natural range 0 to 2 ** (axi_address_bits - 1) - 1;
    variable value : u_unsigned(axi_data_bits - 1 downto 0);
    variable known : std_ulogic;
  begin
    if rising_edge(aclk) then
      offset := to_integer(unsigned(s_axil_araddr(axi_address_bits - 2 downto 0)));
      if s_axil_bready = '1' then
        answer_reg <= '0';
      end if;
      if write_done = '1' then
        answer_reg <= '1';
        answer_error_reg <= not write_is_state;
      end if;

      if s_axil_rready = '1' then
        read_reg <= '0';
      end if;
      if read_taken = '1' then
        read_reg <= '1';
        value := (others => '0');
        known := '1';
        if offset = register_identity then
          value := identity;
        elsif offset = register_status then
          value(0) := core_idle;
        elsif offset = register_primitives then
          value := primitives_reg;
        elsif offset = register_pixels then
          value := pixels_reg;
        elsif offset = register_cut_packets then
          value := cut_packets_reg;
        else
          known := '0';
          for index in generics'range loop
            if offset = register_generics + 4 * index then
              value := to_unsigned(generics(index), axi_data_bits);
              known := '1';
            end if;
          end loop;
        end if;
        -- The shade unit's state cannot be read.
        known := known and s_axil_araddr(axi_address_bits - 1);
        if known = '0' then
          value := (others => '0');
        end if;
        read_data_reg <= value;
        read_error_reg <= not known;
      end if;

      if reset = '1' then
        answer_reg <= '0';
        read_reg <= '0';
      end if;
    end if;
  end process;

end architecture;
