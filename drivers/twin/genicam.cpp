#include "drivers/twin/genicam.hpp"

#include <spdlog/fmt/fmt.h>

#include <string>

#include "core/base/pixel_format.hpp"

namespace ovws::twin {

namespace {

constexpr char kXml[] = R"xml(<?xml version="1.0" encoding="utf-8"?>
<RegisterDescription ModelName="BenchTwin" VendorName="ovws" StandardNameSpace="GEV"
  SchemaMajorVersion="1" SchemaMinorVersion="1" SchemaSubMinorVersion="0"
  MajorVersion="1" MinorVersion="0" SubMinorVersion="0" ToolTip="Digital twin of the ovws bench"
  ProductGuid="8f2c3f5e-6f0a-4a9e-9b1a-0d2f6f0a7710" VersionGuid="8f2c3f5e-6f0a-4a9e-9b1a-0d2f6f0a7711"
  xmlns="http://www.genicam.org/GenApi/Version_1_1"
  xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">

  <Category Name="Root" NameSpace="Standard">
    <pFeature>DeviceControl</pFeature>
    <pFeature>ImageFormatControl</pFeature>
    <pFeature>AcquisitionControl</pFeature>
    <pFeature>AnalogControl</pFeature>
    <pFeature>TransportLayerControl</pFeature>
  </Category>
  <Category Name="DeviceControl" NameSpace="Standard">
    <pFeature>DeviceVendorName</pFeature>
    <pFeature>DeviceModelName</pFeature>
    <pFeature>DeviceManufacturerInfo</pFeature>
    <pFeature>DeviceVersion</pFeature>
    <pFeature>DeviceSerialNumber</pFeature>
    <pFeature>DeviceID</pFeature>
    <pFeature>DeviceUserID</pFeature>
  </Category>
  <StringReg Name="DeviceVendorName" NameSpace="Standard"><Address>0x48</Address><Length>32</Length>
    <AccessMode>RO</AccessMode><pPort>Device</pPort></StringReg>
  <StringReg Name="DeviceModelName" NameSpace="Standard"><Address>0x68</Address><Length>32</Length>
    <AccessMode>RO</AccessMode><pPort>Device</pPort></StringReg>
  <StringReg Name="DeviceVersion" NameSpace="Standard"><Address>0x88</Address><Length>32</Length>
    <AccessMode>RO</AccessMode><pPort>Device</pPort></StringReg>
  <StringReg Name="DeviceManufacturerInfo" NameSpace="Standard"><Address>0xa8</Address><Length>48</Length>
    <AccessMode>RO</AccessMode><pPort>Device</pPort></StringReg>
  <StringReg Name="DeviceSerialNumber" NameSpace="Standard"><Address>0xd8</Address><Length>16</Length>
    <AccessMode>RO</AccessMode><pPort>Device</pPort></StringReg>
  <StringReg Name="DeviceID" NameSpace="Standard"><Address>0xd8</Address><Length>16</Length>
    <AccessMode>RO</AccessMode><pPort>Device</pPort></StringReg>
  <StringReg Name="DeviceUserID" NameSpace="Standard"><Address>0xe8</Address><Length>16</Length>
    <AccessMode>RO</AccessMode><pPort>Device</pPort></StringReg>

  <Category Name="ImageFormatControl" NameSpace="Standard">
    <pFeature>SensorWidth</pFeature>
    <pFeature>SensorHeight</pFeature>
    <pFeature>WidthMax</pFeature>
    <pFeature>HeightMax</pFeature>
    <pFeature>Width</pFeature>
    <pFeature>Height</pFeature>
    <pFeature>OffsetX</pFeature>
    <pFeature>OffsetY</pFeature>
    <pFeature>PixelFormat</pFeature>
  </Category>
  <Integer Name="SensorWidth" NameSpace="Standard"><pValue>SensorWidthRegister</pValue></Integer>
  <IntReg Name="SensorWidthRegister"><Address>0x11c</Address><Length>4</Length><AccessMode>RO</AccessMode>
    <pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>
  <Integer Name="SensorHeight" NameSpace="Standard"><pValue>SensorHeightRegister</pValue></Integer>
  <IntReg Name="SensorHeightRegister"><Address>0x118</Address><Length>4</Length><AccessMode>RO</AccessMode>
    <pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>
  <IntSwissKnife Name="WidthMax"><pVariable Name="S">SensorWidth</pVariable><pVariable Name="O">OffsetXRegister</pVariable>
    <Formula>S - O</Formula></IntSwissKnife>
  <IntSwissKnife Name="HeightMax"><pVariable Name="S">SensorHeight</pVariable><pVariable Name="O">OffsetYRegister</pVariable>
    <Formula>S - O</Formula></IntSwissKnife>
  <IntSwissKnife Name="OffsetXMax"><pVariable Name="S">SensorWidth</pVariable><pVariable Name="W">WidthRegister</pVariable>
    <Formula>S - W</Formula></IntSwissKnife>
  <IntSwissKnife Name="OffsetYMax"><pVariable Name="S">SensorHeight</pVariable><pVariable Name="W">HeightRegister</pVariable>
    <Formula>S - W</Formula></IntSwissKnife>
  <Integer Name="Width" NameSpace="Standard"><Description>Columns of the image.</Description>
    <pValue>WidthRegister</pValue><Min>16</Min><pMax>WidthMax</pMax><Inc>4</Inc></Integer>
  <IntReg Name="WidthRegister"><Address>0x100</Address><Length>4</Length><AccessMode>RW</AccessMode>
    <pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>
  <Integer Name="Height" NameSpace="Standard"><Description>Rows of the image.</Description>
    <pValue>HeightRegister</pValue><Min>16</Min><pMax>HeightMax</pMax><Inc>2</Inc></Integer>
  <IntReg Name="HeightRegister"><Address>0x104</Address><Length>4</Length><AccessMode>RW</AccessMode>
    <pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>
  <Integer Name="OffsetX" NameSpace="Standard"><Description>First column of the sensor in the image.</Description>
    <pValue>OffsetXRegister</pValue><Min>0</Min><pMax>OffsetXMax</pMax><Inc>4</Inc></Integer>
  <IntReg Name="OffsetXRegister"><Address>0x130</Address><Length>4</Length><AccessMode>RW</AccessMode>
    <pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>
  <Integer Name="OffsetY" NameSpace="Standard"><Description>First row of the sensor in the image.</Description>
    <pValue>OffsetYRegister</pValue><Min>0</Min><pMax>OffsetYMax</pMax><Inc>2</Inc></Integer>
  <IntReg Name="OffsetYRegister"><Address>0x134</Address><Length>4</Length><AccessMode>RW</AccessMode>
    <pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>
  <Enumeration Name="PixelFormat" NameSpace="Standard">
@PIXEL_FORMATS@    <pValue>PixelFormatRegister</pValue>
  </Enumeration>
  <IntReg Name="PixelFormatRegister"><Address>0x128</Address><Length>4</Length><AccessMode>RW</AccessMode>
    <pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>

  <Category Name="AcquisitionControl" NameSpace="Standard">
    <pFeature>AcquisitionMode</pFeature>
    <pFeature>AcquisitionStart</pFeature>
    <pFeature>AcquisitionStop</pFeature>
    <pFeature>AcquisitionFrameRate</pFeature>
    <pFeature>AcquisitionResultingFrameRate</pFeature>
    <pFeature>ExposureMode</pFeature>
    <pFeature>ExposureTime</pFeature>
    <pFeature>TriggerSelector</pFeature>
    <pFeature>TriggerMode</pFeature>
    <pFeature>TriggerSource</pFeature>
    <pFeature>TriggerActivation</pFeature>
  </Category>
  <Enumeration Name="AcquisitionMode" NameSpace="Standard">
    <EnumEntry Name="Continuous" NameSpace="Standard"><Value>1</Value></EnumEntry>
    <pValue>AcquisitionModeRegister</pValue>
  </Enumeration>
  <IntReg Name="AcquisitionModeRegister"><Address>0x12c</Address><Length>4</Length><AccessMode>RW</AccessMode>
    <pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>
  <Command Name="AcquisitionStart" NameSpace="Standard"><pValue>AcquisitionRegister</pValue>
    <CommandValue>1</CommandValue></Command>
  <Command Name="AcquisitionStop" NameSpace="Standard"><pValue>AcquisitionRegister</pValue>
    <CommandValue>0</CommandValue></Command>
  <IntReg Name="AcquisitionRegister"><Address>0x124</Address><Length>4</Length><AccessMode>RW</AccessMode>
    <pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>
  <Float Name="AcquisitionFrameRate" NameSpace="Standard"><Description>Frames per second asked for.</Description>
    <pValue>FrameRateConverter</pValue><Min>0.1</Min><Max>1000.0</Max><Unit>Hz</Unit></Float>
  <Converter Name="FrameRateConverter"><FormulaTo>1000000.0 / FROM + 0.5</FormulaTo>
    <FormulaFrom>1000000.0 / TO</FormulaFrom><pValue>WantedPeriodRegister</pValue></Converter>
  <IntReg Name="WantedPeriodRegister"><Address>0x400</Address><Length>4</Length><AccessMode>RW</AccessMode>
    <pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>
  <Float Name="AcquisitionResultingFrameRate" NameSpace="Standard">
    <Description>Frames per second that come: the exposure may not allow those asked for.</Description>
    <pValue>ResultingRateConverter</pValue><ImposedAccessMode>RO</ImposedAccessMode><Unit>Hz</Unit></Float>
  <Converter Name="ResultingRateConverter"><FormulaTo>100000000.0 / FROM</FormulaTo>
    <FormulaFrom>100000000.0 / TO</FormulaFrom><pValue>PeriodRegister</pValue></Converter>
  <IntReg Name="PeriodRegister"><Address>0x408</Address><Length>4</Length><AccessMode>RO</AccessMode>
    <pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>
  <Enumeration Name="ExposureMode" NameSpace="Standard">
    <EnumEntry Name="Timed" NameSpace="Standard"><Value>1</Value></EnumEntry>
    <Value>1</Value>
  </Enumeration>
  <Float Name="ExposureTime" NameSpace="Standard"><Description>Exposure, whole microseconds.</Description>
    <pValue>ExposureConverter</pValue><Min>10.0</Min><Max>1000000.0</Max><Inc>1.0</Inc><Unit>us</Unit></Float>
  <Converter Name="ExposureConverter"><FormulaTo>FROM + 0.5</FormulaTo><FormulaFrom>TO</FormulaFrom>
    <pValue>ExposureRegister</pValue></Converter>
  <IntReg Name="ExposureRegister"><Address>0x120</Address><Length>4</Length><AccessMode>RW</AccessMode>
    <pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>
  <Enumeration Name="TriggerSelector" NameSpace="Standard">
    <EnumEntry Name="FrameStart" NameSpace="Standard"><Value>0</Value></EnumEntry>
    <Value>0</Value>
  </Enumeration>
  <Enumeration Name="TriggerMode" NameSpace="Standard">
    <EnumEntry Name="Off" NameSpace="Standard"><Value>0</Value></EnumEntry>
    <EnumEntry Name="On" NameSpace="Standard"><Value>1</Value></EnumEntry>
    <pValue>TriggerModeRegister</pValue>
  </Enumeration>
  <Enumeration Name="TriggerSource" NameSpace="Standard"><Description>Line0: pulse of the DMD at each pattern.</Description>
    <EnumEntry Name="Line0" NameSpace="Standard"><Value>0</Value></EnumEntry>
    <Value>0</Value>
  </Enumeration>
  <Enumeration Name="TriggerActivation" NameSpace="Standard">
    <EnumEntry Name="RisingEdge" NameSpace="Standard"><Value>0</Value></EnumEntry>
    <Value>0</Value>
  </Enumeration>
  <IntReg Name="TriggerModeRegister"><Address>0x404</Address><Length>4</Length><AccessMode>RW</AccessMode>
    <pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>

  <Category Name="AnalogControl" NameSpace="Standard">
    <pFeature>Gain</pFeature>
  </Category>
  <Float Name="Gain" NameSpace="Standard"><Description>Amplitude gain, steps of 0.1 dB.</Description>
    <pValue>GainConverter</pValue><Min>0.0</Min><Max>48.0</Max><Inc>0.1</Inc><Unit>dB</Unit></Float>
  <Converter Name="GainConverter"><FormulaTo>FROM * 10.0 + 0.5</FormulaTo><FormulaFrom>TO / 10.0</FormulaFrom>
    <pValue>GainRegister</pValue></Converter>
  <IntReg Name="GainRegister"><Address>0x110</Address><Length>4</Length><AccessMode>RW</AccessMode>
    <pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>

  <Category Name="TransportLayerControl" NameSpace="Standard">
    <pFeature>PayloadSize</pFeature>
  </Category>
  <IntSwissKnife Name="PayloadSize"><pVariable Name="W">WidthRegister</pVariable><pVariable Name="H">HeightRegister</pVariable><pVariable Name="F">PixelFormatRegister</pVariable>
    <Formula>W * H * ((F >> 16) &amp; 0xFF) / 8</Formula></IntSwissKnife>
  <Integer Name="TLParamsLocked"><Visibility>Invisible</Visibility><Value>0</Value><Min>0</Min><Max>1</Max></Integer>
  <Port Name="Device" NameSpace="Standard"/>

</RegisterDescription>
)xml";

std::string with_pixel_formats(std::string xml) {
  std::string entries;
  for (const PixelFormatTraits& format : all_pixel_formats()) {
    entries += fmt::format(
        "    <EnumEntry Name=\"{}\" NameSpace=\"Standard\"><Value>{}</Value></EnumEntry>\n",
        format.name, format.code);
  }
  constexpr std::string_view kPlace = "@PIXEL_FORMATS@";
  return xml.replace(xml.find(kPlace), kPlace.size(), entries);
}

}  // namespace

std::string_view genicam_xml() {
  static const std::string xml = with_pixel_formats(kXml);
  return xml;
}

}  // namespace ovws::twin
